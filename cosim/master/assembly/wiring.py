"""The wires of a scenario, element by element, and the bundles that carry the delayed ones."""

from __future__ import annotations

from dataclasses import dataclass, field

from cosim.master.channels.fates import Fates


@dataclass(frozen=True, slots=True, order=True)
class Signal:
    """One element of one variable of one component."""

    component: str
    variable: str
    index: int


@dataclass(frozen=True, slots=True)
class Held:
    """Element ``index`` of what the receiver of a bundle holds."""

    bundle: int
    index: int


@dataclass(frozen=True, slots=True)
class PacketFact:
    """What a bundle says about the packet it holds: ``age`` (ticks) or ``sequence``."""

    bundle: int
    name: str


Source = Signal | Held | PacketFact


@dataclass(frozen=True, slots=True)
class Wire:
    """A value copied into an input element at each step of its component.

    The input gets ``gain * value + offset``; ``from_integer`` turns an int64 into a double.
    """

    source: Source
    target: Signal
    gain: float = 1.0
    offset: float = 0.0
    from_integer: bool = False

    @property
    def is_plain(self) -> bool:
        """Whether the eight bytes are copied as they are."""
        return self.gain == 1.0 and self.offset == 0.0 and not self.from_integer


@dataclass(frozen=True, slots=True)
class Entry:
    """One element of a packet.

    ``target`` is the input whose start value is held before the first arrival; ``None`` where it is
    the source's value at tick 0.
    """

    source: Signal | PacketFact
    is_float: bool
    target: Signal | None


@dataclass(slots=True)
class Bundle:
    """The variables that are sampled, delayed, lost and delivered together."""

    name: str
    channel: str | None
    way: str
    period: int
    fates: Fates
    entries: list[Entry] = field(default_factory=list[Entry])

    @property
    def can_be_immediate(self) -> bool:
        """Whether a packet may arrive in the tick in which it was sampled."""
        return self.fates.shortest <= 0


@dataclass(slots=True)
class Wiring:
    """Every wire and bundle of a run, and what is worth telling about them."""

    wires: list[Wire] = field(default_factory=list[Wire])
    bundles: list[Bundle] = field(default_factory=list[Bundle])
    notes: list[str] = field(default_factory=list[str])
    connection_of: dict[Signal, str] = field(default_factory=dict[Signal, str])
    """The connection, as it was written, that drives an input element."""
