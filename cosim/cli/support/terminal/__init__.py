"""What a command shows, and what a shell offers for it."""
