"""The device side of our serial protocol in plain C, for boards of your own making."""
