"""Workstation 1 of the centralized architecture: the only box, and forces for its clients."""
