"""What goes over the wire, as pure functions from values to bytes and back.

Driver and emulator share the encoders, never the parsers: each side parses what the other sends.
"""
