"""What devices and sensors have in common: a board at an address, and a component of the loop."""
