"""What becomes of a commanded torque before any driver sees it, and who may permit it."""
