"""A run that goes on from where the theory asks it, read in the theory's own coordinates.

The run is put once, beside its operating point, and then left alone: what the map of one
hyperperiod does not know of would be seen in the next.
"""

from __future__ import annotations

import numpy as np

from cosim.analysis.monodromy.run_map import RunMap


def numbers_now(run: RunMap) -> np.ndarray:
    """The coordinates of a run at any multiple of its hyperperiod, rings by age as they are now."""
    found = []
    for each in run.fmus.values():
        words = np.frombuffer(each.fmu.states.save(), dtype=np.int64)
        found.append(words.view(np.float64)[each.declared.places(words)])
    return np.concatenate([*found, *(bundle.numbers() for bundle in run.bundles)])


def continued(run: RunMap, start: np.ndarray, periods: int) -> np.ndarray:
    """The coordinates after each of so many hyperperiods, shape (periods, n)."""
    run.put(start)
    rows = []
    for number in range(1, periods + 1):
        run.simulation.advance(run.tick + number * run.hyperperiod)
        rows.append(numbers_now(run))
    run.put(run.start)
    return np.array(rows)


def pushed(run: RunMap, push: np.ndarray, periods: int) -> np.ndarray:
    """What a small push makes of the coordinates, its even part taken away; shape (periods, n)."""
    start = run.start.copy()
    ways = [continued(run, start + sign * push, periods) for sign in (1.0, -1.0)]
    return (ways[0] - ways[1]) / 2.0
