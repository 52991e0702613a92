"""CANopen: CiA 406 encoders and CiA 401 analogue outputs; driver, protocol, set-up, emulator."""
