"""A remote station as a component: its outputs are what the peer sends, its inputs what we send.

Under the master it stands where the other station's components and the channel stood. It drains
its socket when the tick begins, releases what is due, and sends at the network's ticks once all
outputs are evaluated, exactly where the master samples a simulated channel.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import gcd
from typing import Any

from cosim.base.component import Causality, Cells, Component, Setup, Variable, VariableType
from cosim.link.stream.bundle import Field, PacketBundle
from cosim.link.stream.incoming import Incoming
from cosim.link.stream.peer import PeerState, Reason
from cosim.link.stream.peer_link import PeerLink
from cosim.link.stream.phase import PhaseFollower
from cosim.link.wire.packet import DataWriter


class Grid:
    """Where the own ticks lie on the own clock; the pacer keeps it, links read it.

    ``epoch`` is the own clock (ns) at session tick 0 on the present grid, ``slew`` the relative
    change of the tick period that the phase wants.
    """

    def __init__(self, *, tick_ns: float, epoch: int = 0, first_tick: int = 0) -> None:
        self.tick_ns = tick_ns
        self.epoch = epoch
        self.first_tick = first_tick
        """Session tick of the loop's own tick 0."""
        self.slew = 0.0

    def at_deadline(self, tick: int, deadline: int) -> None:
        """Tick ``tick`` (session) is due at ``deadline`` (ns)."""
        self.epoch = deadline - round(tick * self.tick_ns)


@dataclass(slots=True)
class _Shown:
    """Where one incoming stream's values and state go."""

    item: Incoming
    elements: list[tuple[memoryview[Any], int, bool]]
    """For each element of the packet, the cells it goes to, its place there, and whether they hold
    integers. A memory view takes a plain number at half of an array's cost."""
    weight: memoryview[Any]
    valid: memoryview[Any]
    age: memoryview[Any]
    state: memoryview[Any]
    sequence: memoryview[Any]
    sample: memoryview[Any]
    delay: memoryview[Any]
    reason: memoryview[Any]
    seen: tuple[float, PeerState] | None = field(default=None, init=False)
    """Weight and state as they are shown."""

    def show_values(self) -> None:
        """Copy the packet's elements; one by one, because each may lie somewhere else."""
        values: list[float] = self.item.receiver.values.tolist()
        for (cells, place, whole), value in zip(self.elements, values, strict=True):
            cells[place] = int(value) if whole else value

    def show_facts(self) -> None:
        """What the link says of the stream; mostly it is a tick older, and that is all."""
        item = self.item
        weight = item.weight
        self.age[0] = item.age
        seen = (weight.weight, weight.state)
        if item.fresh or seen != self.seen:
            self.seen = seen
            self.weight[0] = weight.weight
            self.valid[0] = item.valid
            self.state[0] = weight.state
            self.sequence[0] = item.receiver.sequence
            self.sample[0] = item.receiver.sample
            self.delay[0] = item.receiver.delay
        self.reason[0] = weight.reason


class RemoteStation(Component):
    """The peer that one station's link reaches.

    Outputs: every incoming field by name; for each incoming channel ``<channel>.weight`` (0..1),
    ``.valid``, ``.age`` (base ticks), ``.state`` (:class:`~cosim.link.stream.peer.PeerState`) and
    ``.sequence``, ``.sample`` (which of the peer's samples is shown), ``.delay`` (base ticks from
    sample to release), ``.reason``
    (:class:`~cosim.link.stream.peer.Reason`); and ``round_trip``,
    ``clock_offset``, ``phase`` (s), ``clock_skew``.
    Inputs: every outgoing field by name.
    """

    feedthrough = False

    def __init__(
        self,
        link: PeerLink,
        *,
        grid: Grid,
        now: Callable[[], int],
        follower: PhaseFollower | None = None,
    ) -> None:
        """``follower`` slews the own grid to this peer's; without it that is the reference."""
        self.link = link
        self.grid = grid
        self.follower = follower
        self._now = now
        self._tick = 0
        self._update_every = max(1, round(1e9 / grid.tick_ns))
        self._early_every = max(1, self._update_every // 8)
        """Ticks between two looks at the clock; at first there are more."""
        self._variables = _variables(link)
        self._shown: list[_Shown] = []
        self._gather: list[tuple[list[tuple[memoryview[Any], int]], DataWriter]] = []
        self._send_every = gcd(*(bundle.period for bundle in link.outgoing.bundles)) or 1
        self._facts: dict[str, Cells] = {}
        self._read_at: int | None = None
        shortest = min((item.weight.hold for item in link.incoming), default=1)
        self._stall = round((shortest + 1) * grid.tick_ns)
        """ns between two ticks after which the own loop has stood still for too long."""
        link.before_arrival = self._align

    @property
    def variables(self) -> Sequence[Variable]:
        """Every variable; see the class."""
        return self._variables

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Keep the views; show the values that the peer sent before the start, if it did."""
        del setup
        self._shown = []
        for item in self.link.incoming:
            bundle = item.receiver.bundle
            channel = bundle.channel
            facts = {fact: outputs[f"{channel}.{fact}"].data for fact in STREAM_FACTS}
            self._shown.append(
                _Shown(
                    item,
                    [
                        (cells.data, place, whole)
                        for cells, place in _elements(bundle, outputs)
                        for whole in (cells.dtype.kind != "f",)
                    ],
                    **facts,
                )
            )
        self._gather = [
            # A memory view gives plain numbers, which costs half of NumPy's.
            ([(cells.data, at) for cells, at in _elements(bundle, inputs)], writer)
            for bundle, writer in zip(
                self.link.outgoing.bundles, self.link.outgoing.writers, strict=True
            )
        ]
        self._facts = {name: outputs[name] for name in LINK_FACTS}
        for shown in self._shown:
            shown.show_facts()

    def read(self, tick: int) -> None:
        """Drain the socket, release what is due, weigh the peer."""
        session_tick = tick + self.grid.first_tick
        now, before = self._now(), self._read_at
        self._read_at = now
        if before is None:
            if session_tick > 0:
                self.link.ramp()
        elif now - before > self._stall:
            # The hand moved on meanwhile, and so did the peer's.
            self.link.give_up(Reason.STALLED)
        self.link.drain(session_tick)
        self.link.release(session_tick)
        for shown in self._shown:
            if shown.item.fresh:
                shown.show_values()
            shown.show_facts()
        often = self._update_every if self.link.clock.ready else self._early_every
        if session_tick % often == 0:
            self._follow()

    def write(self, tick: int) -> None:
        """Send what is due at this tick."""
        session_tick = tick + self.grid.first_tick
        self._tick = session_tick
        if session_tick % self._send_every == 0:
            self.collect()
            self.link.outgoing.send(session_tick, self._now(), self.grid.epoch)

    def collect(self) -> None:
        """Copy the inputs into the packets."""
        for cells, writer in self._gather:
            writer.fill([cell[place] for cell, place in cells])

    def show_initial(self) -> None:
        """Show values that came before the start."""
        for shown in self._shown:
            shown.show_values()

    def close(self) -> None:
        """Announce an orderly stop."""
        self.link.stop(self._tick, self._now(), self.grid.epoch)

    def _phase(self) -> float:
        """By how much the own ticks come later than the peer's (ns)."""
        # Where the peer has session tick 0, told in the own clock, against the own grid.
        link = self.link
        return self.grid.epoch + link.clock.offset(self._now()) - link.peer_epoch

    def _align(self) -> None:
        """Count by how many ticks the two grids are apart; a grid moves when its loop overruns."""
        link = self.link
        if not link.clock.ready or not link.peer_epoch:
            return
        slip = -int(self._phase() / self.grid.tick_ns)
        for item in link.incoming:
            # A grid that is being slewed is not a grid that slides, unless it is far off.
            near = item.setting.clock == "follow" and abs(slip) < item.receiver.bundle.period
            item.receiver.slip = 0 if near else slip

    def _follow(self) -> None:
        """Once a second, at first more often: fit the clock, find the phase, say how to slew."""
        link, grid = self.link, self.grid
        now = self._now()
        link.clock.update(now)
        if not link.clock.ready or not link.peer_epoch:
            return
        phase = self._phase() * 1e-9
        if self.follower is not None:
            grid.slew = self.follower.update(phase, link.clock.skew)
        self._facts["round_trip"][0] = link.clock.last_round_trip * 1e-9
        self._facts["clock_offset"][0] = link.clock.offset(now) * 1e-9
        self._facts["clock_skew"][0] = link.clock.skew
        self._facts["phase"][0] = phase


STREAM_FACTS = ("weight", "valid", "age", "state", "sequence", "sample", "delay", "reason")
LINK_FACTS = ("round_trip", "clock_offset", "clock_skew", "phase")


def _elements(bundle: PacketBundle, cells: Mapping[str, Cells]) -> list[tuple[Cells, int]]:
    """Where each element of a bundle lies."""
    return [
        (cells[field.name].reshape(-1), place)
        for field in bundle.fields
        for place in range(field.size)
    ]


def _variables(link: PeerLink) -> tuple[Variable, ...]:
    found: list[Variable] = []
    for item in link.incoming:
        bundle = item.receiver.bundle
        found += [_variable(field, Causality.OUTPUT) for field in bundle.fields]
        for fact in STREAM_FACTS:
            kind = VariableType.FLOAT64 if fact == "weight" else VariableType.INT64
            kind = VariableType.BOOLEAN if fact == "valid" else kind
            found.append(
                Variable(
                    name=f"{bundle.channel}.{fact}",
                    type=kind,
                    causality=Causality.OUTPUT,
                    variability="discrete",
                )
            )
    for fact in LINK_FACTS:
        unit = None if fact == "clock_skew" else "s"
        found.append(
            Variable(name=fact, causality=Causality.OUTPUT, variability="discrete", unit=unit)
        )
    for bundle in link.outgoing.bundles:
        found += [_variable(field, Causality.INPUT) for field in bundle.fields]
    return tuple(found)


def _variable(field: Field, causality: Causality) -> Variable:
    kind = VariableType.INT64 if field.integer else VariableType.FLOAT64
    return Variable(
        name=field.name,
        type=VariableType.BOOLEAN if field.boolean else kind,
        causality=causality,
        variability="discrete",
        unit=field.unit,
        is_relative=field.is_relative,
        shape=() if field.size == 1 else (field.size,),
    )
