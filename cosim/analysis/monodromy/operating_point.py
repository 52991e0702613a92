"""Where a run rests: the state that Φ leaves where it is, by Newton's method, stable or not."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

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
FINEST = 1e-13
"""The same below which nothing is left but rounding."""
SETTLING = 1.3
"""By what a step must bring a run nearer for its derivative to serve again."""
PATIENCE = 3
"""After how many steps in a row that do not another derivative is made."""
ITERATIONS = 12
FOLLOW_TIME = {"operator"}
"""Models with states of their own of which some outputs follow time alone."""
DRIFTING = "N.s"
"""Waves travel as integrals, which grow by as much in every hyperperiod under a constant force."""


class Newton:
    """Steps to where Φ(x) = x, by one derivative, of ``size`` numbers."""

    def __init__(self, run: RunMap, matrix: Real) -> None:
        self.size = run.size
        self._kept = ~dropped([matrix])
        units = np.array([one.unit != DRIFTING for one in run.coordinates])
        self._resting = units & self._kept
        self._size = run.steps[self._kept]
        inner = matrix[np.ix_(self._kept, self._kept)] - np.eye(self._size.size)
        self._scaled = inner * self._size[None, :] / self._size[:, None]

    def furthest(self, apart: Real) -> float:
        """How far a coordinate that may rest moves in a hyperperiod."""
        return float(np.abs(apart[self._resting]).max(initial=0.0))

    def step(self, apart: Real) -> Real:
        """From the state that moves by ``apart`` towards one that rests, shape (n,)."""
        return self.steps().next(apart)

    def steps(self) -> Steps:
        """Steps that learn on the way, from this derivative."""
        return Steps(self._inverse, self._kept, self._size)

    @cached_property
    def _inverse(self) -> Real:
        return np.asarray(np.linalg.pinv(self._scaled, rcond=1e-11), dtype=np.float64)


class Steps:
    """One step after the other: each corrects the inverse by what the one before brought.

    Args:
        inverse: of the scaled derivative of Φ(x) − x, shape (m, m).
        kept: which of all coordinates it is of, shape (n,).
        size: of those coordinates, shape (m,).
    """

    def __init__(self, inverse: Real, kept: NDArray[np.bool_], size: Real) -> None:
        self._inverse, self._kept, self._size = inverse, kept, size
        self._last: tuple[Real, Real] | None = None

    def next(self, apart: Real) -> Real:
        """From the state that moves by ``apart``, shape (n,); the last step led to it."""
        here = apart[self._kept] / self._size
        if self._last is not None:
            step, before = self._last
            seen = self._inverse @ (here - before)
            along = float(step @ seen)
            if along != 0.0:
                change = np.outer((step - seen) / along, step @ self._inverse)
                self._inverse = self._inverse + change
        step = self._inverse @ -here
        self._last = step, here
        found = np.zeros(apart.size)
        found[self._kept] = self._size * step
        return found


@dataclass(frozen=True, slots=True)
class Settled:
    """What is known of the derivative of Φ where a run rests.

    Attributes:
        matrix: dΦ/dx there, shape (n, n); None where it was not needed.
        newton: steps by that of a state nearby, which may find others; None of what is linear.
    """

    matrix: Real | None
    newton: Newton | None


def settle(run: RunMap, nearby: Newton | None = None) -> Settled:
    """Bring a run to the fixed point of Φ near where it stands.

    The derivative of a run nearby is tried first: its steps cost one hyperperiod each. Where they
    do not converge quickly, every step takes the derivative of where it begins. Coordinates that
    nothing changes stay as the run left them: which of the equilibria that dry contacts allow it
    is, is the run's choice.

    Args:
        run: stands where the search begins.
        nearby: steps by the derivative of a run nearby.

    Raises:
        InputError: no state nearby rests, or the modes change on the way to it.
    """
    if run.is_linear:
        return Settled(None, None)
    if nearby is not None and nearby.size == run.size:
        begun = run.start.copy()
        if _settles_by(run, nearby):
            _refuse_changing_modes(run)
            return Settled(None, nearby)
        run.move(begun)
    moved = np.inf
    for _ in range(ITERATIONS):
        matrix = jacobian(run)
        newton = Newton(run, matrix)
        apart = run.undisturbed() - run.start
        moved = newton.furthest(apart)
        if moved < CONVERGED:
            _refuse_changing_modes(run)
            _refuse_drifting(run, newton)
            return Settled(matrix, newton)
        run.move(run.start + newton.step(apart))
    raise InputError(
        f"No operating point was found near tick {run.tick}: the state still moves by {moved:.2g} "
        "in a hyperperiod. Choose a moment at which the grasp is steady with --at; where the loop "
        "oscillates, one before it does."
    )


def _settles_by(run: RunMap, newton: Newton) -> bool:
    """Whether steps by one derivative bring the run to rest as finely as Newton's would.

    What every step shows of the derivative here corrects it (Broyden 1965).
    """
    steps, at, lost = newton.steps(), run.start.copy(), 0
    best, least = at, np.inf
    while True:
        apart = run.undisturbed(at) - at
        moved = newton.furthest(apart)
        lost = 0 if moved * SETTLING < least else lost + 1
        if moved < least:
            best, least = at, moved
        if least < FINEST or lost == PATIENCE or not np.isfinite(moved):
            break
        at = at + steps.next(apart)
    if least >= CONVERGED:
        return False
    run.move(best)
    run.undisturbed()
    return True


def _refuse_drifting(run: RunMap, newton: Newton) -> None:
    """Whether the next hyperperiod leaves the state as it is too.

    What users want may move and yet come back to a fixed point of one hyperperiod.

    Raises:
        InputError: it does not.
    """
    moved = newton.furthest(run.follow(run.start, hyperperiods=2) - run.start)
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
    moving = moving_on_the_way(run)
    run.put(run.start)
    return moving


def moving_on_the_way(run: RunMap) -> str | None:
    """The same from where the run is now; it goes on by up to a hyperperiod."""
    before = _timed_outputs(run)
    first = int(run.program.kernel.tick)
    for tick in (first + run.hyperperiod // 2, first + run.hyperperiod):
        run.simulation.advance(tick)
        for name, value in _timed_outputs(run).items():
            if before[name] != value:
                return name
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
