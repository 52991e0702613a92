"""Where a run rests: the state that Φ leaves where it is, by Newton's method, stable or not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.monodromy.blocks import dropped
from cosim.analysis.monodromy.jacobian import jacobian
from cosim.analysis.monodromy.run_map import RunMap
from cosim.base.errors import InputError

Real = NDArray[np.float64]

CONVERGED = 1e-10
"""Of what a coordinate moves in one hyperperiod, in SI units: 0.1 nm, 0.1 nN."""
RESTING = 1e-7
"""The same in the next hyperperiod, in which an unstable loop may have grown."""
ITERATIONS = 12
FOLLOW_TIME = {"operator"}
"""Models with states of their own of which some outputs follow time alone."""
DRIFTING = "N.s"
"""Waves travel as integrals, which grow by as much in every hyperperiod under a constant force."""


def settle(run: RunMap) -> Real:
    """The derivative of Φ at its fixed point, where the run then stands.

    Coordinates that nothing changes stay as the run left them: which of the equilibria that dry
    contacts allow it is, is the run's choice.

    Raises:
        InputError: no state nearby rests, or the modes change on the way to it.
    """
    if run.is_linear:
        return jacobian(run)
    moved = np.inf
    for _ in range(ITERATIONS):
        matrix = jacobian(run)
        apart = run.undisturbed() - run.start
        kept = ~dropped([matrix])
        resting = np.array([one.unit != DRIFTING for one in run.coordinates]) & kept
        moved = float(np.abs(apart[resting]).max(initial=0.0))
        if moved < CONVERGED:
            _refuse_changing_modes(run)
            _refuse_drifting(run, resting)
            return matrix
        step = np.zeros(run.size)
        inner = matrix[np.ix_(kept, kept)] - np.eye(int(np.count_nonzero(kept)))
        size = run.steps[kept]
        scaled = inner * size[None, :] / size[:, None]
        step[kept] = size * np.linalg.lstsq(scaled, -apart[kept] / size, rcond=1e-11)[0]
        run.move(run.start + step)
    raise InputError(
        f"No operating point was found near tick {run.tick}: the state still moves by {moved:.2g} "
        "in a hyperperiod. Choose a moment at which the grasp is steady with --at; where the loop "
        "oscillates, one before it does."
    )


def _refuse_drifting(run: RunMap, resting: NDArray[np.bool_]) -> None:
    """Whether the next hyperperiod leaves the state as it is too.

    What users want may move and yet come back to a fixed point of one hyperperiod.

    Raises:
        InputError: it does not.
    """
    run.put(run.start)
    run.simulation.advance(run.tick + 2 * run.hyperperiod)
    moved = float(np.abs((run.numbers() - run.start)[resting]).max(initial=0.0))
    run.put(run.start)
    if moved > RESTING:
        raise InputError(
            f"At tick {run.tick} the run does not rest: two hyperperiods move its state by "
            f"{moved:.2g}, so that what a user wants moves; choose such a moment with --at that it "
            "stands still."
        )


def _refuse_changing_modes(run: RunMap) -> None:
    for name, each in run.fmus.items():
        changed = each.changed_mode()
        if changed is not None:
            raise InputError(
                f"At tick {run.tick} {name}: {changed} changes within a hyperperiod, so that the "
                "run has no operating point there; choose another moment with --at."
            )


def refuse_moving(run: RunMap) -> None:
    """Whether signals and operators stand still over the hyperperiod.

    Raises:
        InputError: one of them moves, by name.
    """
    moving = moving_inputs(run)
    if moving is not None:
        raise InputError(
            f"At tick {run.tick} {moving} changes with time, and a run has an operating point only "
            "where what users want stands still: choose such a moment with --at."
        )


def moving_inputs(run: RunMap) -> str | None:
    """The first output that follows time alone and is not constant, ``component.variable``."""
    if run.is_linear:
        return None
    before = _timed_outputs(run)
    for tick in (run.tick + run.hyperperiod // 2, run.tick + run.hyperperiod):
        run.simulation.advance(tick)
        for name, value in _timed_outputs(run).items():
            if before[name] != value:
                run.put(run.start)
                return name
    run.put(run.start)
    return None


def _timed_outputs(run: RunMap) -> dict[str, float]:
    """Every output that no input and no state moves."""
    wired = {
        (link.target.component, _bare(link.target.path))
        for link in run.simulation.scenario.connections
    }
    parts = run.simulation.scenario.components
    found: dict[str, float] = {}
    for name, each in run.fmus.items():
        if each.declared.live and parts[name].source not in FOLLOW_TIME:
            continue
        moved_inputs = {path for component, path in wired if component == name}
        found |= {
            f"{name}.{path}": value for path, value in each.timed_outputs(moved_inputs).items()
        }
    return found


def _bare(path: str) -> str:
    """Without the element."""
    return path.partition("[")[0]
