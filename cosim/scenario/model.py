"""The scenario as the rest of cohaptic sees it: resolved, typed, in SI units and ticks.

What a user writes is described by ``cosim.scenario.form.document``; ``cosim.scenario.load``
turns the one into the other. Rates are exact fractions of a hertz, time is an integer number of
base ticks, and nothing in here can change once it is loaded.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal

from cosim.base.document.node import Node, PathKey
from cosim.base.errors import Location
from cosim.scenario.impairments.effect import Effect

Value = float | int | bool | str | tuple[Any, ...]
"""A parameter or start value: a scalar, or a tuple (of tuples) for an array."""


class Kind(StrEnum):
    """What computes a component."""

    FMU = "fmu"
    PYTHON = "python"
    DEVICE = "device"
    PLAYBACK = "playback"
    TABLE = "table"


@dataclass(frozen=True, kw_only=True)  # no slots: see ``cosim.base.changed``
class ScenarioComponent:
    """One thing with inputs and outputs, and how often it steps."""

    name: str
    kind: Kind
    source: str
    """fmu: a bundled model's name or an absolute path; python: ``module:Class``; device: a URL;
    playback: the absolute path of a run folder; table: that of a file."""
    station: str
    rate_name: str | None
    """The name in ``rates``, ``None`` where the rate was written as a number."""
    rate: Fraction
    """Steps a second (Hz)."""
    period: int
    """Base ticks from one step to the next."""
    flavour: str = "fmi3"
    """Which archive of a bundled FMU: fmi2, fmi3 (scalars) or fmi3-arrays."""
    substeps: int = 1
    """FMI ``doStep`` calls in one period, each of period / substeps."""
    feedthrough: bool | None = None
    """Whether declared output-on-input dependencies count within a tick; ``None`` (python, device)
    leaves it to the component itself. A bundled FMU has ``True``, any other ``False``."""
    is_strict: bool = False
    """fmu: whether a description that breaks rules of the standard is refused; else it is noted."""
    event_mode: bool | None = None
    """fmu: whether its event mode is used; ``None``: where it has clocks."""
    is_isolated: bool = False
    """fmu: whether it is asked to run in a process of its own."""
    parameters: Mapping[str, Value] = field(default_factory=dict[str, Value])
    """Values by variable name; groups are joined by dots (``finger_1.base_x``)."""
    start: Mapping[str, Value] = field(default_factory=dict[str, Value])
    """Start values of inputs, and of outputs that allow one, by variable name."""
    options: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """What belongs to the kind alone: a device's further settings, ``component`` of a playback,
    ``columns``, ``interpolate`` and ``time_offset`` of a table."""

    @property
    def is_bundled(self) -> bool:
        """Whether ``source`` is the name of one of our own FMUs rather than a file."""
        return self.kind is Kind.FMU and not Path(self.source).is_absolute()


@dataclass(frozen=True, slots=True, kw_only=True)
class Delay:
    """A delay of whole base ticks; ``samples`` says it was written as that many samples."""

    ticks: int = 0
    samples: int | None = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Direction:
    """What happens to the packets of one direction of a channel; draws are per packet."""

    delay: Delay = Delay()
    impairments: Mapping[str, Effect] = field(default_factory=dict[str, Effect])
    """What is drawn or repeated for each packet, by the key it is written under."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """What values cross from one station to another; forward is from ``between[0]``."""

    name: str
    between: tuple[str, str]
    rate_name: str | None
    rate: Fraction
    """Packets a second (Hz); a sample of the channel is one packet."""
    period: int
    """Base ticks from one packet to the next."""
    forward: Direction = Direction()
    backward: Direction = Direction()
    options: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Settings of a real link that stands in for the simulated channel (``link:``)."""

    def direction(self, source: str, target: str) -> Direction:
        """The direction from one station to another; ``KeyError`` where it does not join them."""
        return {self.between: self.forward, self.between[::-1]: self.backward}[source, target]


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """``component.path``: a variable, an array, a terminal or a dotted group of a component.

    ``component`` may also name a channel, for what it says about its packets
    (``lan.forward.age``).
    """

    component: str
    path: str

    def __str__(self) -> str:
        return f"{self.component}.{self.path}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Connection:
    """An output to an input: sampled, delayed, held in between."""

    source: Reference
    target: Reference
    via: str | None = None
    """The channel that it crosses; ``None`` inside one station."""
    rate: Fraction | None = None
    """Samples a second; ``None``: the channel's rate, or every value the source shows."""
    period: int | None = None
    """Base ticks from one sample to the next; ``None`` with ``rate``."""
    delay: Delay = Delay()
    """Delay inside a station; through a channel it is the channel's and this one is zero."""
    initial: Literal["source", "start"] = "source"
    """What is held before the first sample arrives: the source's value at tick 0, or the input's
    own start value."""
    ignores_unit: bool = False
    """Whether the number passes as it is, whatever the units of both ends say."""
    factor: float = 1.0
    offset: float = 0.0
    """Target = factor * source + offset, behind the conversion of units."""

    def __str__(self) -> str:
        return f"{self.source} -> {self.target}" + (f" via {self.via}" if self.via else "")


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """Signals to record, as a pattern over ``component.variable``."""

    pattern: str
    """``*`` and ``?`` as in file names, brackets literal; naming a group or an array means all of
    it."""
    rate: Fraction | None = None
    """Rows a second; ``None`` records at the component's own rate."""
    period: int | None = None
    """Base ticks from one row to the next; ``None`` with ``rate``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KnobRange:
    """Something that may be turned while the scenario runs, and between which values.

    ``target`` is a component's tunable parameter, or ``forward.delay`` and the like of a channel.
    """

    target: Reference
    minimum: Value | None = None
    """``None``: what its component or channel says itself."""
    maximum: Value | None = None
    written: tuple[PathKey, ...] = field(default=(), compare=False, repr=False)
    """Where it is in the document, for what is wrong with it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """A knob that is turned at a tick: the first thing that is done in it.

    A channel's value is in SI units: a delay of whole ticks (s), a jitter (s), a probability.
    """

    tick: int
    target: Reference
    value: Value
    written: tuple[PathKey, ...] = field(default=(), compare=False, repr=False)
    """Where it is in the document, for what is wrong with it."""


@dataclass(frozen=True, kw_only=True)  # no slots: see ``cosim.base.changed``
class Scenario:
    """A complete, checked scenario. Make one with :func:`cosim.scenario.load`."""

    cohaptic: int
    """Version of the scenario language."""
    name: str
    """The file's name without folder and ``.yaml``; names the run's folder."""
    file: Path = field(compare=False)
    title: str
    description: str = ""
    duration: Fraction
    """Simulated time (s)."""
    ticks: int
    """Simulated time in base ticks; a duration between two ticks is rounded up."""
    start_tick: int = 0
    """How many base ticks after time 0 its first tick is; ticks themselves count from there."""
    base_rate: Fraction
    """Base ticks a second (Hz): the least common multiple of all rates unless it is given."""
    seed: int = 0
    rates: Mapping[str, Fraction]
    components: Mapping[str, ScenarioComponent]
    channels: Mapping[str, Channel] = field(default_factory=dict[str, Channel])
    connections: tuple[Connection, ...] = ()
    knobs: tuple[KnobRange, ...] = ()
    """What may be turned while it runs, besides what events and connections turn."""
    events: tuple[Event, ...] = ()
    """What is turned while it runs, in the order of their ticks."""
    record: tuple[Record, ...] = ()
    expect: Mapping[str, Mapping[str, Any]] = field(default_factory=dict[str, Mapping[str, Any]])
    """Acceptance conditions by signal; their names belong to the record."""
    safety: Mapping[str, Any] = field(default_factory=dict[str, Any])
    realtime: Mapping[str, Any] = field(default_factory=dict[str, Any])
    link: Mapping[str, Any] = field(default_factory=dict[str, Any])

    root: Node = field(repr=False, compare=False)
    """The document as it was written, after includes, overlays and overrides."""

    @property
    def start_time(self) -> Fraction:
        """The time of the first tick (s)."""
        return self.start_tick / self.base_rate

    @property
    def stations(self) -> tuple[str, ...]:
        """Every station's name, in the order of first mention."""
        return tuple(dict.fromkeys(part.station for part in self.components.values()))

    def locate(self, path: tuple[PathKey, ...]) -> Location:
        """Where a node was written: ``("components", "vr_a", "parameters", "finger_1.base_x")``.

        A path that leads nowhere gives the place of the deepest node on it that exists.
        """
        return self.root.locate(path)
