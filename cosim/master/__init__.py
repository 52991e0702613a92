"""The master: from a scenario to a schedule, and from a schedule to a run.

``simulation.assemble`` is the way in; the loop itself is C (``kernel/``), driven in chunks of ticks.
"""
