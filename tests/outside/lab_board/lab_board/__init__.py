"""A board of our own for cohaptic: protocol, driver, emulator, and what its mechanism is like."""
