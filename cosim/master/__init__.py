"""The master: from a scenario to a schedule, and from a schedule to a run.

``simulation.assemble`` is the way in; the loop itself is C (``kernel/``), run in chunks of ticks.
"""
