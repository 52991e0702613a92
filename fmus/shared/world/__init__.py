"""Box, contact, walls, ground and soft object."""
