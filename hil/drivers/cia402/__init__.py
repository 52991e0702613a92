"""CiA 402 drives in torque mode; driver, protocol, set-up, emulator."""
