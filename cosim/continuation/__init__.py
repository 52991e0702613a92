"""``run --snapshot`` and ``run --from``: states left in a run's folder, and runs from there."""
