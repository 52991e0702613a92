"""The loops of chapters 3 and 4 as matrices, by three independent routes."""
