"""What a person, or an emulator, has to move so that a device file becomes true."""
