"""Emulated devices: other processes that move a simulated pantograph and speak the real bytes."""
