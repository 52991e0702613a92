"""One user's workstation with its own copy of the box, coupled to the copies of its peers."""
