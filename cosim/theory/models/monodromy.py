"""The frame map tick by tick: a plain simulation of one hyperperiod from every unit state.

The independent third route: no matrix of the loop is formed, forces come from written-out
spring-damper laws, and packets carry whole positions and velocities. Every value is an array with
one entry per unit state, so that all of them are simulated at once.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cosim.theory.models.mass_spring_damper import Centralized, Model
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import Real


@dataclass(slots=True)
class _Mass:
    """A mass under a held force, advanced by its exact motion."""

    mass: float
    damping: float
    stiffness: float = 0.0
    position: Real = field(default_factory=lambda: np.zeros(1))
    velocity: Real = field(default_factory=lambda: np.zeros(1))
    force: Real = field(default_factory=lambda: np.zeros(1))

    def advance(self, time: float) -> None:
        if self.stiffness:
            self._swing(time)
            return
        if self.damping == 0.0:
            acceleration = self.force / self.mass
            self.position = (
                self.position + self.velocity * time + acceleration * (time * time / 2.0)
            )
            self.velocity = self.velocity + acceleration * time
            return
        constant = self.mass / self.damping
        terminal = self.force / self.damping
        decay = float(np.exp(-time / constant))
        coasted = (self.velocity - terminal) * (constant * (1.0 - decay))
        self.position = self.position + terminal * time + coasted
        self.velocity = terminal + (self.velocity - terminal) * decay

    def _swing(self, time: float) -> None:
        """Around the rest position F/k, by the two (complex) rates of m s² + b s + k = 0."""
        half = self.damping / (2.0 * self.mass)
        root = np.sqrt(complex(half * half - self.stiffness / self.mass))
        one, two = -half + root, -half - root
        rest = self.force / self.stiffness
        first = (self.velocity - two * (self.position - rest)) / (one - two)
        second = (self.position - rest) - first
        first, second = first * np.exp(one * time), second * np.exp(two * time)
        self.position = rest + (first + second).real
        self.velocity = (one * first + two * second).real


@dataclass(slots=True)
class _Pipe:
    """A delay line: what goes in comes out ``delay`` pushes later, and is held in between."""

    width: int
    delay: int
    waiting: list[list[Real]] = field(default_factory=list[list[Real]])
    held: list[Real] = field(default_factory=list[Real])

    def push(self, values: list[Real]) -> None:
        self.waiting.append(values)
        self.held = self.waiting.pop(0)


class _World:
    """A cooperative loop that can be run tick by tick."""

    def __init__(self, model: Model, timing: Timing) -> None:
        self.model = model
        self.timing = timing
        users = range(model.users)
        self.hands = [
            _Mass(float(model.hand_mass[m]), float(model.hand_damping[m]), model.hand_stiffness)
            for m in users
        ]
        forward, backward = timing.delay.forward, timing.delay.backward
        late = timing.computation_delay
        if isinstance(model, Centralized):
            self.objects = [_Mass(model.object_mass, 0.0)]
            self.up = {m: _Pipe(2, forward) for m in users if m > 0 and model.present[m]}
            self.down = {m: _Pipe(1, backward) for m in self.up}
            pipes = [*self.up.values(), *self.down.values()]
        else:
            self.objects = [_Mass(float(mass), 0.0) for mass in model.object_mass]
            self.peer = {
                (m, r): _Pipe(4 if model.present[r] else 2, forward if r < m else backward)
                for m in users
                for r in users
                if m != r
            }
            pipes = list(self.peer.values())
        # One computation delay line per force on an object: from user r's side, or the wall's.
        self.late = {
            (m, name): _Pipe(1, late)
            for m in range(len(self.objects))
            for name in (*[r for r in users if m == r or self.hears(m, r)], "wall")
        }
        self.pipes = [*pipes, *self.late.values()]
        self.seen: dict[int, tuple[Real, Real]] = {}
        """Position and velocity of each mass at the last control tick."""
        self.masses = [hand for m, hand in enumerate(self.hands) if model.present[m]]
        self.masses += self.objects

    def hears(self, m: int, r: int) -> bool:
        """Whether object m is coupled to what user r sends."""
        return r != m and (not isinstance(self.model, Centralized) or self.model.present[r])

    def delayed(self, m: int, name: int | str, force: Real) -> Real:
        self.late[m, name].push([force])
        return self.late[m, name].held[0]

    def spring(self, k: float, b: float, a: tuple[Real, Real], c: tuple[Real, Real]) -> Real:
        return k * (a[0] - c[0]) + b * (a[1] - c[1])

    def measure(self) -> None:
        """What the stations know of their bodies from this control tick on."""
        self.seen = {id(mass): (mass.position, mass.velocity) for mass in self.masses}

    def known(self, mass: _Mass) -> list[Real]:
        """Position and velocity of a mass, as a station sends them."""
        if self.timing.sampling == "between_ticks":
            return [mass.position, mass.velocity]
        return list(self.seen[id(mass)])

    def network_instant(self) -> None:
        """Sample and deliver what crosses the network at this instant."""
        model = self.model
        if isinstance(model, Centralized):
            for m, pipe in self.up.items():
                pipe.push(self.known(self.hands[m]))
            return
        for (_, r), pipe in self.peer.items():
            sent = [self.objects[r], self.hands[r]] if model.present[r] else [self.objects[r]]
            pipe.push([value for mass in sent for value in self.known(mass)])

    def control_instant(self) -> None:
        """Compute every force that is computed at T_c, and apply it from now on."""
        model = self.model
        rest = np.zeros_like(self.objects[0].position)
        for m, copy in enumerate(self.objects):
            own = (copy.position, copy.velocity)
            total = coupler = rest
            hand = self.hands[m]
            if model.present[m]:
                if isinstance(model, Centralized):
                    k, b = model.stiffness[m], model.damping[m]
                else:
                    k, b = model.local_stiffness[m], model.local_damping[m]
                coupler = self.spring(k, b, (hand.position, hand.velocity), own)
            coupler = self.delayed(m, m, coupler)
            hand.force = -coupler
            total = total + coupler
            if isinstance(model, Centralized):
                for r, pipe in self.up.items():
                    sent = (pipe.held[0], pipe.held[1])
                    force = self.spring(model.stiffness[r], model.damping[r], sent, own)
                    total = total + self.delayed(m, r, force)
            else:
                for r in range(model.users):
                    if r == m:
                        continue
                    held = self.peer[m, r].held
                    k, b = model.object_stiffness[m, r], model.object_damping[m, r]
                    force = self.spring(k, b, (held[0], held[1]), own)
                    if model.present[r]:
                        k, b = model.remote_stiffness[m, r], model.remote_damping[m, r]
                        force = force + self.spring(k, b, (held[2], held[3]), own)
                    total = total + self.delayed(m, r, force)
            wall = self.spring(model.wall_stiffness, model.wall_damping, (rest, rest), own)
            total = total + self.delayed(m, "wall", wall)
            compensation = (
                model.compensation
                if isinstance(model, Centralized)
                else float(model.compensation[m])
            )
            copy.force = total - compensation * copy.velocity

    def downlink(self) -> None:
        """Centralized: what the server's couplers apply at this instant goes down."""
        model = self.model
        if not isinstance(model, Centralized):
            return
        copy = self.objects[0]
        for m, pipe in self.down.items():
            if self.timing.computation_delay or self.timing.sampling == "last_tick":
                force = self.late[0, m].held[0]
            else:
                up = self.up[m].held
                force = self.spring(
                    model.stiffness[m],
                    model.damping[m],
                    (up[0], up[1]),
                    (copy.position, copy.velocity),
                )
            pipe.push([force])

    def render(self) -> None:
        """Centralized: what has come down acts on the hands."""
        if isinstance(self.model, Centralized):
            for m, pipe in self.down.items():
                self.hands[m].force = -pipe.held[0]

    def run(self) -> None:
        """One hyperperiod, instant by instant, in the order deliver, compute, send, advance."""
        timing = self.timing
        tick = float(timing.base_period)
        for now in range(timing.hyperperiod_ticks):
            if now % timing.control_ticks == 0:
                self.measure()
            if now % timing.network_ticks == 0:
                self.network_instant()
            if now % timing.control_ticks == 0:
                self.control_instant()
            if now % timing.network_ticks == 0:
                self.downlink()
            if now % timing.control_ticks == 0 or timing.sampling == "between_ticks":
                self.render()
            for mass in self.masses:
                mass.advance(tick)

    def values(self) -> list[Real]:
        """Every committed value, in a fixed order."""
        moving = [value for mass in self.masses for value in (mass.position, mass.velocity)]
        return moving + [v for pipe in self.pipes for sent in pipe.waiting for v in sent]

    def is_position(self) -> list[bool]:
        """Which of the values move along when everything is moved."""
        packets = [pipe.width > 1 for pipe in self.pipes for _ in range(pipe.delay * pipe.width)]
        moving = [place % 2 == 0 for place in range(2 * len(self.masses))]
        # A packet is (position, velocity) pairs; a force on its way is no position.
        return moving + [packet and n % 2 == 0 for n, packet in enumerate(packets)]

    def start(self, values: list[Real]) -> None:
        """Put the committed values in place."""
        source = iter(values)
        for mass in self.masses:
            mass.position, mass.velocity = next(source), next(source)
        for pipe in self.pipes:
            pipe.waiting = [[next(source) for _ in range(pipe.width)] for _ in range(pipe.delay)]


def monodromy(model: Model, timing: Timing) -> tuple[Real, Real]:
    """The map over one hyperperiod, from a simulation of every unit state.

    Returns:
        The map, shape (n, n), and the translation, shape (n,). n counts every value under way on
        the network, so the matrix is larger than that of the other routes; its nonzero eigenvalues
        are the same.

    Raises:
        InputError: where a delay is no whole number of network samples.
    """
    timing.refuse_ticks()
    world = _World(model, timing)
    moves = world.is_position()
    world.start(list(np.eye(len(moves))))
    world.run()
    return np.array(world.values()), np.array(moves, dtype=np.float64)
