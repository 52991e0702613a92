"""Two ODrive axes on CAN; driver, protocol, emulator."""
