"""Values: what a packet carries, when it is shown, and how much of a peer still counts."""
