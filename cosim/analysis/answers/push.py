"""A force on a user's hand in a run, and what moves: the way in and out of Φ."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.monodromy.run_map import RunMap
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.scenario import Connection, Scenario

Real = NDArray[np.float64]

FORCE = 1e-3
"""Newtons by which a hand is pushed, where the run is not linear; 1 N where it is."""
WEIGHT = "tracking.weight"
"""The share of its force with which an operator that follows a target holds on."""
_CONSTANT = 1
_WRITTEN = ("force_amplitude", "force_mode", "force_rectify", "force_command")


@dataclass(frozen=True, slots=True)
class Push:
    """Where a force acts and where it is read: a variable of an FMU each.

    Attributes:
        source: the component whose variable is the force, and that variable.
        hand: the component that moves, and its velocity and position.
        axis: 0 for x, 1 for y; 0 on one axis.
    """

    source: tuple[str, str]
    hand: str
    velocity: str
    position: str
    axis: int


def find_push(scenario: Scenario, user: str | None, axis: int = 0, number: int = 0) -> Push:
    """The force of a user: a hand's, or an operator's on its device.

    Args:
        scenario: what runs.
        user: the hand's or the operator's name; None: the one of that number.
        axis: of a planar one, 0 or 1.
        number: counted from 0 in the order they are written.

    Raises:
        InputError: there is no such hand, or a force added to what drives it is not what it gets.
    """
    parts = {n: p for n, p in scenario.components.items() if p.is_bundled}
    hands = [name for name, part in parts.items() if part.source in {"hand", "operator"}]
    if not hands:
        raise InputError(
            "The scenario has no hand and no operator, so nobody feels anything.",
            scenario.locate(("components",)),
        )
    if user is None:
        user = hands[min(number, len(hands) - 1)]
    if user not in hands:
        raise InputError(
            f"--user {user}: there is no hand or operator of that name.{did_you_mean(user, hands)}"
        )
    if parts[user].source == "operator":
        return _operator(scenario, user, axis)
    driven = next(
        (
            link
            for link in scenario.connections
            if link.target.component == user and link.target.path == "force"
        ),
        None,
    )
    if driven is None:
        return Push((user, "force"), user, "velocity", "position", 0)
    driver = driven.source.component
    if driver in parts and parts[driver].source == "signal":
        if driven.source.path != "value":
            raise InputError(
                f"{user} is pushed by {driven.source}, which no force can be added to; connect "
                f"{driver}.value.",
                scenario.locate(("components", user)),
            )
        _refuse_another_force(scenario, driven, lambda _: True)
        return Push((driver, "offset"), user, "velocity", "position", 0)
    raise InputError(
        f"{user} is pushed by {driver}, whose force cannot be added to; push it by a signal.",
        scenario.locate(("components", user)),
    )


def _operator(scenario: Scenario, user: str, axis: int) -> Push:
    held = next(
        (link for link in scenario.connections if link.source.component == user and _holds(link)),
        None,
    )
    if held is None or scenario.components[held.target.component].source != "pantograph":
        raise InputError(
            f"{user} holds no pantograph, so that its hand is not simulated.",
            scenario.locate(("components", user)),
        )
    _refuse_another_force(scenario, held, _holds)
    device = held.target.component
    element = f"[{axis + 1}]"
    return Push(
        (user, f"force_amplitude{element}"),
        device,
        f"tip_velocity{element}",
        f"tip_position{element}",
        axis,
    )


def _holds(link: Connection) -> bool:
    return link.target.path.endswith("hand_force")


def _refuse_another_force(
    scenario: Scenario, driven: Connection, pushes: Callable[[Connection], bool]
) -> None:
    """Refuse what makes a newton at the source another one at the hand, or one on others as well.

    Args:
        scenario: what runs.
        driven: from the source to the hand.
        pushes: whether a connection from the same source moves something.

    Raises:
        InputError: with the connection's place.
    """
    late = driven.via is not None or driven.delay.ticks or driven.rate is not None
    for number, link in enumerate(scenario.connections):
        if link.source != driven.source:
            continue
        place = scenario.locate(("connections", number))
        if link is driven and (late or link.factor != 1.0):
            raise InputError(
                f"{link} has a factor, a delay or a rate of its own, so that a force added there "
                f"is another one on {link.target.component}: connect the two as they are.",
                place,
            )
        if link is not driven and pushes(link):
            raise InputError(
                f"{link}: what pushes {driven.target.component} pushes this too, and what is felt "
                "is of a force on one hand: give each its own.",
                place,
            )


@dataclass(frozen=True, slots=True)
class PushResponse:
    """What a force in each tick of the hyperperiod does.

    Attributes:
        force: shape (n, ticks): on the state at the end, of 1 N during one tick.
        read: shape (ticks, n): the output at each tick, of the state at the start.
        direct: shape (ticks, ticks): the output at a tick, of 1 N during another.
    """

    force: Real
    read: Real
    direct: Real


def held_push(run: RunMap, pushes: Sequence[Push]) -> Real:
    """The effect on the state of 1 N over a hyperperiod, shape (n,), shared by several hands."""
    size = 1.0 if run.is_linear else FORCE
    run.undisturbed()
    ends: list[Real] = []
    for sign in (1.0, -1.0):
        run.put(run.start)
        for push in pushes:
            _set(run, push, _amplitude(run, push), sign * size / len(pushes))
        run.simulation.advance(run.tick + run.hyperperiod)
        ends.append(run.numbers())
    return np.asarray((ends[0] - ends[1]) / (2.0 * size))


def push_response(run: RunMap, push: Push, output: str) -> PushResponse:
    """The effect of a push tick by tick; ``output`` is the hand's variable that is read."""
    size = 1.0 if run.is_linear else FORCE
    run.undisturbed()
    start, ticks = run.start, run.hyperperiod
    force, direct = np.zeros((run.size, ticks)), np.zeros((ticks, ticks))
    for pushed in range(ticks):
        up, down = (_follow(run, push, output, start, {pushed: s * size}) for s in (1.0, -1.0))
        force[:, pushed] = (up[0] - down[0]) / (2.0 * size)
        direct[:, pushed] = (up[1] - down[1]) / (2.0 * size)
    read = np.zeros((ticks, run.size))
    for number, step in enumerate(run.steps):
        ends: list[Real] = []
        places: list[float] = []
        for sign in (1.0, -1.0):
            moved = start.copy()
            moved[number] += sign * step
            places.append(float(moved[number]))
            ends.append(_follow(run, push, output, moved, {})[1])
        read[:, number] = (ends[0] - ends[1]) / (places[0] - places[1])
    return PushResponse(force, read, direct)


def _follow(
    run: RunMap, push: Push, output: str, state: Real, forces: dict[int, float]
) -> tuple[Real, Real]:
    """The state at the end, and the output at every tick, with forces in some of the ticks."""
    run.put(state)
    seen = np.zeros(run.hyperperiod)
    was = _amplitude(run, push)
    for tick in range(run.hyperperiod):
        seen[tick] = run.output(push.hand, output)
        if tick in forces:
            _set(run, push, was, forces[tick])
        run.simulation.advance(run.tick + tick + 1)
        if tick in forces:
            _set(run, push, was, 0.0)
    return run.numbers(), seen


def _amplitude(run: RunMap, push: Push) -> dict[str, float]:
    """What a force is added to; of an operator also how that is written, and what it makes now.

    Raises:
        InputError: the operator has let go of its target, so that its force counts in part.
    """
    component, variable = push.source
    if not variable.startswith("force_amplitude"):
        return {variable: run.output(component, variable)}
    for number, one in enumerate(run.coordinates):
        if (one.owner, one.name) == (component, WEIGHT) and run.start[number] != 1.0:
            raise InputError(
                f"At tick {run.tick} {component} has no target any more and holds on with "
                f"{run.start[number]:.0%} of its force: choose a moment with --at at which it has."
            )
    element = f"[{push.axis + 1}]"
    return {f"{name}{element}": run.output(component, f"{name}{element}") for name in _WRITTEN}


def _set(run: RunMap, push: Push, was: dict[str, float], force: float) -> None:
    """Add to a force, however it is written: its size counts in full only where it is constant."""
    component, variable = push.source
    element = f"[{push.axis + 1}]"
    wanted = f"force_command{element}"
    if wanted not in was:
        values = {variable: was[variable] + force}
    elif force:
        values = {
            f"force_mode{element}": _CONSTANT,
            f"force_rectify{element}": 0,
            variable: was[wanted] + force,
        }
    else:
        values = {name: value for name, value in was.items() if name != wanted}
    run.fmus[component].overwrite(values)
