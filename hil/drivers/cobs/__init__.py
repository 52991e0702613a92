"""Home-made boards behind our framed protocol; driver, protocol, emulator."""
