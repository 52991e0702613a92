"""Haply 2DIY boards; driver, protocol, emulator."""
