"""Every hand between a light and a heavy, a limp and a stiff one: μ of the lifted loop.

A hand's mass, and the stiffness and damping with which it holds on to where it wants to be (a force
sampled at T_c), are constant but unknown within intervals. A force f on a mass m moves it by
T²/2m f and changes its velocity by T/m f in a tick, so that the loop is affine in 1/m, in k and in
b, tick by tick; over a frame of N ticks each of them is a real number that is repeated N times:

    s⁺ = A s + B d,   z = C s + D d,   d = Δ z,   Δ = diag(δ_p I_N),   −1 ≤ δ_p ≤ 1.

Where the loop in the middle is stable and μ_Δ(C (zI − A)⁻¹ B + D) < 1 on |z| = 1, it is stable with
every hand of the intervals (Packard and Doyle 1993).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.models.assembly import assemble
from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import Complex, Real, spectral_radius
from cosim.theory.robust.structured import Scalings, Uncertain, upper_bound
from cosim.theory.stability.quotient import without_translation

Interval = tuple[float, float]
LEADING = 1
"""Rows of each parameter's scalings that are its own: over a frame its signals hardly change."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """What is unknown of one hand.

    Attributes:
        hand: station whose hand it is, counted from 0.
        name: mass (kg), stiffness (N/m) or damping (N·s/m).
        low: the interval's start.
        high: its end.
    """

    hand: int
    name: str
    low: float
    high: float

    @property
    def middle(self) -> float:
        """Half way; of a mass by its inverse, in which the loop is affine."""
        if self.name == "mass":
            return 2.0 / (1.0 / self.low + 1.0 / self.high)
        return (self.low + self.high) / 2.0

    @property
    def spread(self) -> float:
        """Half the interval; of a mass that of its inverse, relative to the middle."""
        if self.name == "mass":
            return (self.high - self.low) / (self.high + self.low)
        return (self.high - self.low) / 2.0

    def at(self, delta: float) -> float:
        """The value that δ stands for."""
        if self.name == "mass":
            return self.middle / (1.0 + self.spread * delta)
        return self.middle + self.spread * delta


@dataclass(frozen=True, slots=True)
class UncertainLoop:
    """The loop with Δ taken out of it.

    Attributes:
        parameters: one δ each.
        samples: N, how often each is repeated.
        a, b, c, d: s⁺ = A s + B d and z = C s + D d; d and z parameter by parameter.
        translation: s after everything moved by 1 m, or None where something holds it.
        period: T_t in s.
    """

    parameters: tuple[Parameter, ...]
    samples: int
    a: Real
    b: Real
    c: Real
    d: Real
    translation: Real | None
    period: float

    def map_at(self, deltas: Real) -> Real:
        """The one-frame map with Δ closed, shape (n, n)."""
        delta = np.repeat(deltas, self.samples)
        inner = np.eye(delta.size) - self.d * delta[None, :]
        return self.a + self.b @ (delta[:, None] * np.linalg.solve(inner, self.c))

    def radius_at(self, deltas: Real) -> float:
        """ρ of that map without translation."""
        found = self.map_at(deltas)
        if self.translation is not None:
            found = without_translation(found, self.translation)
        return spectral_radius(found)

    def response(self, frequency: float) -> Complex:
        """C (zI − A)⁻¹ B + D at z = e^{jωT_t}, its first rows turned to what leads."""
        z = np.exp(1j * frequency * self.period)
        inner = np.linalg.solve(z * np.eye(len(self.a)) - self.a, self.b.astype(np.complex128))
        found = self.c @ inner + self.d
        turn = np.kron(np.eye(len(self.parameters)), _leading_basis(z, self.samples))
        return turn.conj().T @ found @ turn


@dataclass(frozen=True, slots=True)
class HandRobustness:
    """What is known of the loop with every hand of the intervals.

    Attributes:
        bound: no μ on the grid is larger; 1/bound of the intervals, from the middle, is proved.
        frequency: where the bound is largest, rad/s.
        nominal: ρ in the middle.
        worst: the largest ρ in a corner.
        corner: the values there, by ``hand.name``.
    """

    bound: float
    frequency: float
    nominal: float
    worst: float
    corner: Mapping[str, float]

    @property
    def verdict(self) -> str:
        """``stable`` with every hand, ``unstable`` with the corner's, or ``undecided``."""
        if self.nominal >= 1.0 or self.worst >= 1.0:
            return "unstable"
        return "stable" if self.bound < 1.0 else "undecided"


def uncertain_hands(
    model: Model, timing: Timing, intervals: Mapping[str, Interval]
) -> UncertainLoop:
    """The loop in which every hand that takes part is unknown within intervals.

    Args:
        model: the loop; its hands' own damping must be 0.
        timing: rates and delay; a whole ratio.
        intervals: of ``mass``, ``stiffness`` and ``damping``; what is missing is as the model has
            it, and no holding on.

    Raises:
        InputError: an interval is empty or not positive, or a hand is damped already.
    """
    _judge(model, intervals)
    hands = [m for m in range(model.users) if model.present[m]]
    parameters = tuple(
        Parameter(hand, name, *intervals[name])
        for hand in range(len(hands))
        for name in ("stiffness", "damping", "mass")
        if name in intervals
    )
    if "mass" in intervals:
        mass = model.hand_mass.copy()
        mass[hands] = Parameter(0, "mass", *intervals["mass"]).middle
        model = replace(model, hand_mass=mass)
    assembly = assemble(model, timing)
    frame = assembly.frame()
    tick_period = float(timing.control_period)
    m, n, samples = len(frame.tick), len(frame.map), frame.samples
    width = n + samples * len(parameters)
    places = [place for place in frame.hand if place is not None]
    moved = np.zeros((m, width))
    moved[:, :m] = np.eye(m)
    held = np.zeros((len(frame.held), width))
    held[:, :n] = frame.held
    seen = np.zeros((len(parameters) * samples, width))
    for k in range(samples):
        after = frame.tick @ moved + frame.held_effect @ held
        for hand, place in enumerate(places):
            inertia = float(model.hand_mass[hands[hand]])
            own = (after[place + 1] - moved[place + 1]) * (inertia / tick_period)
            extra = np.zeros(width)
            for number, one in enumerate(parameters):
                if one.hand != hand:
                    continue
                signal = number * samples + k
                if one.name == "mass":
                    # Of everything that acts on it.
                    seen[signal] = one.spread * (own + extra)
                else:
                    value = moved[place + (one.name == "damping")]
                    extra -= one.middle * value
                    seen[signal] = -one.spread * value
                extra[n + signal] += 1.0
            after = after + np.outer(frame.force_on_hand[hand], extra)
        moved = after
    a = np.vstack([moved[:, :n], frame.map[m:]])
    b = np.vstack([moved[:, n:], np.zeros((n - m, width - n))])
    free = not model.grounded and "stiffness" not in intervals
    return UncertainLoop(
        parameters=parameters,
        samples=samples,
        a=a,
        b=b,
        c=seen[:, :n],
        d=seen[:, n:],
        translation=frame.translation if free else None,
        period=float(timing.network_period),
    )


def robustness(loop: UncertainLoop, frequencies: Real, accuracy: float = 1e-2) -> HandRobustness:
    """The largest μ bound over frequencies, and the worst corner.

    A frequency is bisected only where the largest bound so far does not hold there.
    """
    structure = tuple(Uncertain("real", loop.samples, LEADING) for _ in loop.parameters)
    scalings = Scalings.of(structure)
    responses = {float(w): loop.response(float(w)) for w in frequencies}
    norms = {w: float(np.linalg.norm(response, 2)) for w, response in responses.items()}
    bound, place = 1e-3, float(frequencies[0])
    # The largest first, so that the others are asked only whether they are smaller.
    for frequency in sorted(responses, key=lambda w: -norms[w]):
        if norms[frequency] > bound and not scalings.prove(responses[frequency], bound):
            bound, place = upper_bound(responses[frequency], structure, accuracy), frequency
    corners = list(_corners(loop))
    radii = [loop.radius_at(corner) for corner in corners]
    worst = int(np.argmax(radii))
    return HandRobustness(
        bound=bound,
        frequency=place,
        nominal=loop.radius_at(np.zeros(len(loop.parameters))),
        worst=radii[worst],
        corner={
            f"{one.name} {one.hand + 1}": one.at(float(delta))
            for one, delta in zip(loop.parameters, corners[worst], strict=True)
        },
    )


def _corners(loop: UncertainLoop) -> Iterator[Real]:
    for signs in itertools.product((-1.0, 1.0), repeat=len(loop.parameters)):
        yield np.array(signs)


def _leading_basis(z: complex, samples: int) -> Complex:
    """Orthonormal columns, first what turns by ωT_c a tick."""
    turns = z ** (np.arange(samples) / samples)
    full = np.hstack([turns[:, None], np.eye(samples, dtype=np.complex128)])
    return np.linalg.qr(full)[0][:, :samples]


def _judge(model: Model, intervals: Mapping[str, Interval]) -> None:
    if not intervals:
        raise InputError("Say what is unknown of the hands: a mass, stiffness or damping LOW:HIGH.")
    for name, (low, high) in intervals.items():
        if not 0 < low < high:
            raise InputError(
                f"A hand's {name} lies between LOW and HIGH with 0 < LOW < HIGH, not {low:g}:"
                f"{high:g}. A hand that lets go is a hand with little of it."
            )
    if np.any(model.hand_damping != 0) or model.hand_stiffness != 0:
        raise InputError(
            "A hand with physical damping or stiffness of its own is not affine in its mass: "
            "leave b_h at 0, and give --hand-damping LOW:HIGH."
        )
