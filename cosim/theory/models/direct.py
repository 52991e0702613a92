"""The two architectures as sampled signals on a continuous plant, for direct lifting (4.2.2).

The feedback laws are (4.26) and (4.28) in one world frame, with X_h2 in the third line of (4.26)
where the thesis prints X_h1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cosim.theory.models.lifting import Lifted, LiftedSignal, lift
from cosim.theory.models.mass_spring_damper import Centralized, Distributed, Model
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import Real


@dataclass(slots=True)
class _Plant:
    """Bodies of the continuous plant: state (position, velocity) of each, in order of addition."""

    masses: list[float]
    dampings: list[float]
    stiffnesses: list[float]

    def add(self, mass: float, damping: float, stiffness: float = 0.0) -> int:
        self.masses.append(mass)
        self.dampings.append(damping)
        self.stiffnesses.append(stiffness)
        return len(self.masses) - 1

    @property
    def size(self) -> int:
        return 2 * len(self.masses)

    def matrix(self) -> Real:
        A = np.zeros((self.size, self.size))
        bodies = zip(self.masses, self.dampings, self.stiffnesses, strict=True)
        for body, (mass, damping, stiffness) in enumerate(bodies):
            A[2 * body, 2 * body + 1] = 1.0
            A[2 * body + 1, 2 * body] = -stiffness / mass
            A[2 * body + 1, 2 * body + 1] = -damping / mass
        return A

    def row(self, *terms: tuple[int, float, float]) -> Real:
        """Σ k x + b v over (body, k, b)."""
        row = np.zeros(self.size)
        for body, stiffness, damping in terms:
            row[2 * body] += stiffness
            row[2 * body + 1] += damping
        return row

    def force(self, *terms: tuple[int, float]) -> Real:
        """What 1 N, applied to each body with the sign given, does to ẋ."""
        column = np.zeros(self.size)
        for body, sign in terms:
            column[2 * body + 1] += sign / self.masses[body]
        return column


@dataclass(frozen=True, slots=True)
class DirectModel:
    """A lifted loop with the places of its bodies.

    Attributes:
        lifted: the loop over one hyperperiod, with a constant force on what was asked for.
        hand: index of each hand's position in the state, None where there is no hand.
        body: index of each object copy's position.
        translation: the state after everything moved by 1 m.
        network_samples: network samples per hyperperiod.
    """

    lifted: Lifted
    hand: tuple[int | None, ...]
    body: tuple[int, ...]
    translation: Real
    network_samples: int


def direct_model(
    model: Model, timing: Timing, *, push_hands: tuple[int, ...] = (), push_objects: bool = False
) -> DirectModel:
    """Lift a model over its hyperperiod.

    Args:
        model: the loop.
        timing: its rates and delays; the ratio may be any rational.
        push_hands: users on whose hand the external constant force of 1 N acts.
        push_objects: whether it acts on every object copy as well.
    """
    plant = _Plant([], [], [])
    hands: list[int | None] = [
        plant.add(float(model.hand_mass[m]), float(model.hand_damping[m]), model.hand_stiffness)
        if model.present[m]
        else None
        for m in range(model.users)
    ]
    if isinstance(model, Centralized):
        bodies = [plant.add(model.object_mass, 0.0)]
        signals = _centralized_signals(model, timing, plant, hands, bodies[0])
    else:
        bodies = [plant.add(float(mass), 0.0) for mass in model.object_mass]
        signals = _distributed_signals(model, timing, plant, hands, bodies)
    pushed = [(hands[m], 1.0) for m in push_hands]
    terms = [(body, sign) for body, sign in pushed if body is not None]
    if push_objects:
        terms += [(body, 1.0) for body in bodies]
    tick = float(timing.base_period)
    lifted = lift(plant.matrix(), signals, tick, plant.force(*terms), timing.hyperperiod_ticks)

    moved = np.zeros(lifted.map.shape[0])
    moved[0 : plant.size : 2] = 1.0
    values: list[float] = []
    for signal in signals:
        values.append(
            float(signal.state @ moved[: plant.size])
            + sum(gain * values[other] for other, gain in signal.others.items())
        )
    for signal, value, start in zip(signals, values, lifted.memory, strict=True):
        moved[start : start + signal.delay] = value
    return DirectModel(
        lifted=lifted,
        hand=tuple(None if body is None else 2 * body for body in hands),
        body=tuple(2 * body for body in bodies),
        translation=moved,
        network_samples=timing.control_ticks,
    )


def _distributed_signals(
    model: Distributed,
    timing: Timing,
    plant: _Plant,
    hands: list[int | None],
    bodies: list[int],
) -> list[LiftedSignal]:
    control, network = timing.control_ticks, timing.network_ticks
    late = timing.computation_delay
    ahead, back = timing.delay.ways
    signals: list[LiftedSignal] = []
    for m, copy in enumerate(bodies):
        heard: dict[int, float] = {}
        own: list[tuple[int, float, float]] = []
        for r, other in enumerate(bodies):
            if r == m:
                continue
            pairs = [(other, model.object_stiffness[m, r], model.object_damping[m, r])]
            hand = hands[r]
            if hand is not None:
                pairs.append((hand, model.remote_stiffness[m, r], model.remote_damping[m, r]))
            for body, stiffness, damping in pairs:
                row = plant.row((body, float(stiffness), float(damping)))
                sent = LiftedSignal(network, row, known=_known(timing))
                heard[_sent(signals, sent, ahead if r < m else back)] = 1.0
                own.append((copy, -float(stiffness), -float(damping)))
        own.append((copy, -model.wall_stiffness, -model.wall_damping))
        signals.append(
            LiftedSignal(control, plant.row(*own), heard, plant.force((copy, 1.0)), delay=late)
        )
        signals.extend(
            _local(
                plant, hands[m], copy, (model.local_stiffness[m], model.local_damping[m]), timing
            )
        )
        signals.append(_compensation(plant, copy, float(model.compensation[m]), control))
    return signals


def _centralized_signals(
    model: Centralized, timing: Timing, plant: _Plant, hands: list[int | None], body: int
) -> list[LiftedSignal]:
    control, network = timing.control_ticks, timing.network_ticks
    late = timing.computation_delay
    ahead, back = timing.delay.ways
    signals = _local(plant, hands[0], body, (model.stiffness[0], model.damping[0]), timing)
    for m in range(1, model.users):
        hand = hands[m]
        if hand is None:
            continue
        stiffness, damping = float(model.stiffness[m]), float(model.damping[m])
        sent = LiftedSignal(network, plant.row((hand, stiffness, damping)), known=_known(timing))
        up = _sent(signals, sent, ahead)
        own = plant.row((body, -stiffness, -damping))
        computed = len(signals)
        signals.append(LiftedSignal(control, own, {up: 1.0}, plant.force((body, 1.0)), delay=late))
        # What goes down: the coupler's force at the network instant, or that of the last tick.
        from_hand = plant.force((hand, -1.0))
        relayed = timing.sampling == "last_tick" and timing.ratio.denominator != 1
        passed = late or relayed
        force = LiftedSignal(
            network,
            np.zeros(plant.size) if passed else own,
            {computed: 1.0} if passed else {up: 1.0},
            None if relayed else from_hand,
        )
        down = _sent(signals, force, back)
        if relayed:  # the hand's device takes it at its own next tick
            nothing = np.zeros(plant.size)
            signals.append(LiftedSignal(control, nothing, {down: 1.0}, from_hand))
    wall = plant.row((body, -model.wall_stiffness, -model.wall_damping))
    signals.append(LiftedSignal(control, wall, {}, plant.force((body, 1.0)), delay=late))
    signals.append(_compensation(plant, body, model.compensation, control))
    return signals


def _sent(signals: list[LiftedSignal], sent: LiftedSignal, delay: tuple[int, int]) -> int:
    """Add what the network carries as it is heard, (samples, ticks) later; that signal's number.

    The ticks are those of a second signal, which takes the first at every tick.
    """
    samples, ticks = delay
    signals.append(replace(sent, delay=samples, force=None if ticks else sent.force))
    if ticks:
        last = {len(signals) - 1: 1.0}
        signals.append(LiftedSignal(1, np.zeros(sent.state.size), last, sent.force, delay=ticks))
    return len(signals) - 1


def _known(timing: Timing) -> int:
    """At the multiples of how many base ticks a station knows what it sends."""
    return timing.control_ticks if timing.sampling == "last_tick" else 0


def _local(
    plant: _Plant, hand: int | None, body: int, gains: tuple[float, float], timing: Timing
) -> list[LiftedSignal]:
    """The coupler of a user's own hand, computed at T_c."""
    if hand is None:
        return []
    k, b = float(gains[0]), float(gains[1])
    row = plant.row((hand, k, b), (body, -k, -b))
    force = plant.force((hand, -1.0), (body, 1.0))
    return [LiftedSignal(timing.control_ticks, row, {}, force, delay=timing.computation_delay)]


def _compensation(plant: _Plant, body: int, value: float, control: int) -> LiftedSignal:
    return LiftedSignal(control, plant.row((body, 0.0, -value)), {}, plant.force((body, 1.0)))
