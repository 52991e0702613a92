"""Serial ports and CAN buses as a loop uses them: never blocking, every byte accounted for."""
