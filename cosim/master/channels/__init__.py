"""What becomes of packets: the fates that are drawn for them, and the memory they travel in."""
