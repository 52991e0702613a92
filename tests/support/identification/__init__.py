"""Runs whose every number is known: computed backwards from a motion, or moved by an emulator."""
