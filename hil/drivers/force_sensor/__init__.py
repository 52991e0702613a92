"""Force sensors behind our framed protocol; driver, protocol, emulator."""
