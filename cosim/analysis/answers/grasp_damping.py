"""The damping that a grasp feels in steady motion, and the compensation that nulls it.

The hands let go of the places that they hold on to, and keep the forces that they hold them with.
What is left is as much at rest wherever the grasp is carried, so that it may drift: at 1 m/s the
forces f on a user's hand and the state s₀ beside the motion t of everything solve

    (M − I) s₀ + B f = T t,

as for the loops of chapter 6 (steady.py), with both axes at once: D in f = D v has a row an axis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.answers.asked import AskedRun
from cosim.analysis.answers.push import Push, find_push, held_push
from cosim.analysis.grasp import WORKSTATION
from cosim.analysis.left_out import SERVER
from cosim.analysis.monodromy.blocks import dropped
from cosim.analysis.monodromy.point import Point, find_point
from cosim.base.errors import InputError
from cosim.scenario import Scenario

Real = NDArray[np.float64]

AXES = ("x", "y")
TIP = "own.finger[0].position"
"""Where a workstation has seen its first finger last: what says how far a grasp has moved."""
HOLDS_STILL = 1e-6
"""How far a motion of everything may be from neutral, per hyperperiod and as a share of it."""
COMPENSATED = (WORKSTATION, SERVER)
"""The models whose box takes a compensation."""
NULLED = 1e-7
"""Of what is felt without compensation: what may be left (the differences know no more)."""
STEPS = 12
MOST = 1000.0
"""N·s/m up to which a compensation is looked for."""


@dataclass(frozen=True, slots=True)
class Carriers:
    """One user's hands, which share what the grasp is carried with.

    Attributes:
        operators: by name.
        pushes: a force on each of them, per axis.
    """

    operators: tuple[str, ...]
    pushes: tuple[tuple[Push, ...], ...]


def carriers(scenario: Scenario, user: str | None) -> Carriers:
    """The hands of the user that an operator belongs to: all operators of its station.

    Args:
        scenario: what runs.
        user: an operator; None: the first, in a centralized scenario the first remote one.

    Raises:
        InputError: there is none of that name, or it holds no pantograph.
    """
    if user is None:
        user = _first(scenario)
    station = scenario.components[find_push(scenario, user).source[0]].station
    names = tuple(
        name
        for name, part in scenario.components.items()
        if part.is_bundled and part.source == "operator" and part.station == station
    )
    pushes = tuple(
        tuple(find_push(scenario, name, axis) for name in names) for axis in range(len(AXES))
    )
    return Carriers(names, pushes)


def _first(scenario: Scenario) -> str | None:
    parts = [part for part in scenario.components.values() if part.is_bundled]
    servers = {part.station for part in parts if part.source == SERVER}
    operators = [part for part in parts if part.source == "operator"]
    remote = [part.name for part in operators if servers and part.station not in servers]
    return remote[0] if remote else None


def released(point: Point) -> list[str]:
    """The overrides with which every hand keeps its force, and lets go of its place."""
    run = point.run
    run.undisturbed()
    sets: list[str] = []
    for name, part in run.simulation.scenario.components.items():
        if not part.is_bundled or part.source != "operator":
            continue
        force = [run.output(name, f"force[{axis + 1}]") for axis in range(len(AXES))]
        given = {
            "impedance": "custom",
            "stiffness": "[0.0, 0.0]",
            "damping": "[0.0, 0.0]",
            "force_mode": "[constant, constant]",
            "force_rectify": "[false, false]",
            "force_amplitude": f"[{force[0]!r}, {force[1]!r}]",
        }
        sets += [f"components.{name}.parameters.{key}={value}" for key, value in given.items()]
    return sets


@dataclass(frozen=True, slots=True)
class Drift:
    """What it takes to carry a grasp at 1 m/s, along x and along y.

    Attributes:
        damping: D, shape (2, 2), N·s/m: a column is the force on the hands, x and y, of one drift.
        state: s₀, shape (n, 2): how the run stands beside its operating point meanwhile.
    """

    damping: Real
    state: Real


def carried(point: Point, hands: Carriers) -> Drift:
    """What it takes to carry a grasp whose hands have let go of their places.

    Raises:
        InputError: something holds the grasp in its place.
    """
    run = point.run
    kept = ~dropped([point.matrix])
    size = run.steps[kept]
    apart = point.matrix[np.ix_(kept, kept)] * size[None, :] / size[:, None] - np.eye(size.size)
    tips = [_tip(point, kept, axis) for axis in AXES]
    motions = np.column_stack([_motion(apart, tips, axis) for axis in range(len(AXES))])
    pushed = np.column_stack([held_push(run, pushes)[kept] / size for pushes in hands.pushes])
    # The motions move a tip by its step: the speed is that step a second.
    speed = float(size[int(np.flatnonzero(tips[0])[0])])
    system = np.hstack([apart, pushed * speed])
    solution = np.linalg.lstsq(system, float(point.seconds) * motions, rcond=1e-13)[0]
    state = np.zeros((run.size, len(AXES)))
    state[kept] = solution[: size.size] * size[:, None] / speed
    return Drift(np.asarray(solution[size.size :], dtype=np.float64), state)


def _tip(point: Point, kept: NDArray[np.bool_], axis: str) -> NDArray[np.bool_]:
    names = np.array([one.name == f"{TIP}.{axis}" for one in point.run.coordinates])[kept]
    if not names.any():
        raise InputError("No workstation sees a finger, so that nobody carries anything.")
    return np.asarray(names)


def _motion(apart: Real, tips: Sequence[NDArray[np.bool_]], axis: int) -> Real:
    """The motion of everything along an axis, every tip by its step.

    Raises:
        InputError: it is not neutral.
    """
    rows = np.flatnonzero(tips[0] | tips[1])
    wanted = np.array([1.0 if tips[axis][row] else 0.0 for row in rows])
    system = np.vstack([apart, np.eye(apart.shape[0])[rows]])
    right = np.concatenate([np.zeros(apart.shape[0]), wanted])
    motion = np.linalg.lstsq(system, right, rcond=1e-13)[0]
    if np.abs(system @ motion - right).max() > HOLDS_STILL:
        raise InputError(
            "The damping is a property of free motion, and this grasp is held in its place by more "
            "than hands (a wall, the ground, a mechanical stop): take that away, or ask for the "
            "admittance."
        )
    return np.asarray(motion, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class GraspDamping:
    """What a user feels who carries the grasp, and what nulls it, per axis.

    Attributes:
        operators: the user's hands.
        damping: N·s/m, along x and y.
        compensation: b_c of every copy of the box at which it vanishes, N·s/m.
        radius: of the run with that compensation, its hands holding on as they do.
        verdict: stable, neutral or unstable.
    """

    operators: tuple[str, ...]
    damping: Mapping[str, float]
    compensation: Mapping[str, float]
    radius: float
    verdict: str


def null_grasp_damping(asked: AskedRun, user: str | None) -> GraspDamping:
    """The damping of a planar run, and the compensation on both axes at which it vanishes.

    No delay is rounded: packets take their ticks in the map as in the run.

    Raises:
        InputError: something holds the grasp, or no compensation up to 1000 N·s/m is enough.
    """
    hands = carriers(asked.scenario, user)
    point = asked.point()
    free = released(point)
    with find_point(asked.written.changed(free), asked.at, point) as start:
        present = np.diag(carried(start, hands).damping)

        def damping(value: Real) -> Real:
            sets = [*free, *compensation_sets(asked.scenario, value)]
            with find_point(asked.written.changed(sets), asked.at, start) as there:
                return np.diag(carried(there, hands).damping)

        value = _nulled(damping, len(_boxes(asked.scenario)))
    held = asked.point(compensation_sets(asked.scenario, value)).spectrum()
    return GraspDamping(
        hands.operators,
        dict(zip(AXES, map(float, present), strict=True)),
        dict(zip(AXES, map(float, value), strict=True)),
        held.radius,
        held.verdict,
    )


def compensation_sets(scenario: Scenario, value: Sequence[float] | Real) -> list[str]:
    """The overrides that give every copy of the box b_c along x and y (N·s/m).

    Raises:
        InputError: the scenario has no box to compensate.
    """
    boxes = _boxes(scenario)
    if not boxes:
        raise InputError("The scenario has no object whose compensation could null the damping.")
    return [
        f"components.{name}.parameters.compensation.{axis}={float(one)!r}"
        for name in boxes
        for axis, one in zip(AXES, value, strict=True)
    ]


def _boxes(scenario: Scenario) -> list[str]:
    return [
        name
        for name, part in scenario.components.items()
        if part.is_bundled and part.source in COMPENSATED
    ]


def _nulled(damping: Callable[[Real], Real], copies: int) -> Real:
    """Both axes at once by secants: one hardly feels the other's compensation.

    Raises:
        InputError: none up to 1000 N·s/m is enough.
    """
    before = np.zeros(len(AXES))
    felt_before = damping(before)
    enough = NULLED * np.maximum(np.abs(felt_before), 1e-3)
    now = before - felt_before / copies
    for _ in range(STEPS):
        felt = damping(now)
        done = np.abs(felt) <= enough
        if done.all():
            return now
        slope = np.where(
            now != before,
            (felt - felt_before) / np.where(now != before, now - before, 1.0),
            float(copies),
        )
        before, felt_before = now, felt
        now = np.where(done, now, now - felt / slope)
        if np.abs(now).max() > MOST or not np.isfinite(now).all():
            break
    raise InputError(
        f"No compensation up to {MOST:g} N·s/m nulls what is felt: lower the stiffness, the delay "
        "or the ratio of the rates."
    )
