"""What the workstation models have in common."""
