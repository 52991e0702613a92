"""Sweeps in memory: where a grasp breaks, what realism costs, what prediction gains, more users."""
