"""A run: components started, ticks executed, paced or not, and everything closed."""
