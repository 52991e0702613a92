"""A remote user's workstation in the centralized architecture: renders the forces it is sent."""
