"""Which signals are recorded, at which rates, and what their columns are called."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field

from cosim.base.component import Causality, VariableType
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from cosim.base.recording import Column, RecordGroup, TextColumn
from cosim.base.suggest import did_you_mean, index_hint
from cosim.base.wildcard import compile_wildcard, is_wild
from cosim.master.assembly.wiring import PacketFact, Signal, Wiring
from cosim.master.components.interface import Interface
from cosim.scenario import Scenario
from cosim.scenario.presets import PRESETS, RecordPreset, named_in

_FACTS = {
    "age": "Age of the packet that the receiver holds (base ticks)",
    "sequence": "Number of the packet that the receiver holds; -1 before the first",
}


@dataclass(slots=True)
class Selected:
    """The recorded signals of one rate, by column name; texts apart."""

    period: int
    signals: dict[str, Signal | PacketFact] = field(default_factory=dict[str, Signal | PacketFact])
    texts: dict[str, Signal] = field(default_factory=dict[str, Signal])

    def only(self, names: Collection[str]) -> Selected:
        """The same without the others."""
        kept = {name: signal for name, signal in self.signals.items() if name in names}
        texts = {name: signal for name, signal in self.texts.items() if name in names}
        return Selected(self.period, kept, texts)

    @property
    def read(self) -> list[Signal]:
        """What components are read for."""
        return [s for s in (*self.signals.values(), *self.texts.values()) if isinstance(s, Signal)]


@dataclass(slots=True)
class _Candidate:
    name: str
    signal: Signal | PacketFact
    period: int
    usual: bool
    """Matched by a pattern, not only by its exact name."""


@dataclass(slots=True)
class _Candidates:
    """Everything that can be recorded, and the same by component or channel."""

    every: list[_Candidate] = field(default_factory=list[_Candidate])
    of: dict[str, list[_Candidate]] = field(default_factory=dict[str, list[_Candidate]])


def select_recorded(
    scenario: Scenario,
    interfaces: Mapping[str, Interface],
    wiring: Wiring,
    problems: Problems,
) -> list[Selected]:
    """The groups of recorded signals, the fastest first.

    A pattern takes outputs, connected inputs, what may be turned and facts about packets; any
    other variable is recorded where it is named exactly, or as an array, terminal or group.
    """
    if not scenario.record:
        return []
    driven = set(wiring.connection_of)
    candidates = _Candidates()
    for candidate in (*_variables(scenario, interfaces, driven), *_packet_facts(scenario, wiring)):
        candidates.every.append(candidate)
        candidates.of.setdefault(candidate.name.partition(".")[0], []).append(candidate)
    groups: dict[int, Selected] = {}
    for number, record in enumerate(scenario.record):
        with problems.at(("record", number)):
            for found in _recorded(record.pattern, candidates, interfaces, scenario):
                period = record.period or found.period
                group = groups.setdefault(period, Selected(period))
                if isinstance(found.signal, Signal) and _is_text(found.signal, interfaces):
                    group.texts.setdefault(found.name, found.signal)
                else:
                    group.signals.setdefault(found.name, found.signal)
    return [groups[period] for period in sorted(groups)]


def describe_groups(
    scenario: Scenario, interfaces: Mapping[str, Interface], selected: list[Selected]
) -> list[RecordGroup]:
    """What a recorder is told about the groups."""
    return [
        RecordGroup(
            name=_group_name(scenario, group.period),
            period=group.period,
            columns=tuple(
                _column(name, signal, interfaces) for name, signal in group.signals.items()
            ),
            texts=tuple(
                _text_column(name, signal, interfaces) for name, signal in group.texts.items()
            ),
        )
        for group in selected
    ]


def _variables(
    scenario: Scenario, interfaces: Mapping[str, Interface], driven: set[Signal]
) -> Iterator[_Candidate]:
    for component, interface in sorted(interfaces.items()):
        period = _period(scenario, component)
        for name, element in interface.elements.items():
            causality = interface.variables[element.variable].causality
            signal = Signal(component, element.variable, element.index)
            is_turned = element.variable in interface.knobs
            usual = causality is Causality.OUTPUT or is_turned or signal in driven
            yield _Candidate(f"{component}.{name}", signal, period, usual)


def _period(scenario: Scenario, name: str) -> int:
    """That of a component; of a channel, that of its packets."""
    component = scenario.components.get(name)
    return scenario.channels[name].period if component is None else component.period


def _packet_facts(scenario: Scenario, wiring: Wiring) -> Iterator[_Candidate]:
    for number, bundle in enumerate(wiring.bundles):
        if bundle.channel is None:
            continue
        channel = scenario.channels[bundle.channel]
        station = channel.between[1 if bundle.way == "forward" else 0]
        period = min(
            (part.period for part in scenario.components.values() if part.station == station),
            default=bundle.period,
        )
        for fact in _FACTS:
            yield _Candidate(f"{bundle.name}.{fact}", PacketFact(number, fact), period, usual=True)


def _recorded(
    pattern: str,
    known: _Candidates,
    interfaces: Mapping[str, Interface],
    scenario: Scenario,
) -> list[_Candidate]:
    """What a pattern or a preset stands for."""
    if pattern not in PRESETS:
        return _matches(pattern, known, interfaces, scenario)
    wanted = PRESETS[pattern]
    found = [c for c in known.every if c.usual and _is_for(c, wanted, interfaces)]
    for name in named_in(scenario.expect):
        with suppress(InputError):  # who reads the expectation says what is wrong with it
            found += _matches(name, known, interfaces, scenario)
    if not found:
        raise InputError(
            f"'{pattern}' stands for what {wanted.purpose}, and there is nothing of it here: name "
            "the signals that you want."
        )
    return found


def _is_for(
    candidate: _Candidate, wanted: RecordPreset, interfaces: Mapping[str, Interface]
) -> bool:
    signal = candidate.signal
    if isinstance(signal, PacketFact):
        return wanted.with_packets
    variable = interfaces[signal.component].variables[signal.variable]
    return variable.meaning_of(signal.index) in wanted.meanings


def _matches(
    pattern: str,
    known: _Candidates,
    interfaces: Mapping[str, Interface],
    scenario: Scenario,
) -> list[_Candidate]:
    component, _, path = pattern.partition(".")
    is_open = is_wild(component)
    candidates = known.every if is_open else known.of.get(component, [])
    if is_wild(pattern):
        expression = compile_wildcard(pattern)
        found = [c for c in candidates if c.usual and expression.fullmatch(c.name)]
        if (
            not found
            and not any(expression.fullmatch(c.name) for c in candidates)
            and (pattern != "*")
        ):
            raise InputError(f"nothing that can be recorded matches '{pattern}'")
        return found
    exact = [c for c in candidates if c.name == pattern]
    if exact:
        return exact
    if component in interfaces:
        wanted = {
            Signal(component, element.variable, element.index)
            for element in interfaces[component].select(path).members.values()
        }
        return [c for c in candidates if c.signal in wanted]
    if component in scenario.components:
        return []  # it could not be loaded, which has been reported
    names = {c.name for c in known.every} | set(scenario.components)
    hint = index_hint(pattern) or did_you_mean(pattern, names)
    raise InputError(f"there is no signal '{pattern}' to record.{hint}")


def _group_name(scenario: Scenario, period: int) -> str:
    rate = scenario.base_rate / period
    names = sorted(name for name, named in scenario.rates.items() if named == rate)
    return names[0] if names else f"{float(rate):g}Hz"


def _is_text(signal: Signal, interfaces: Mapping[str, Interface]) -> bool:
    return interfaces[signal.component].variables[signal.variable].type.is_text


def _text_column(name: str, signal: Signal, interfaces: Mapping[str, Interface]) -> TextColumn:
    variable = interfaces[signal.component].variables[signal.variable]
    return TextColumn(
        name=name,
        is_binary=variable.type is VariableType.BINARY,
        description=variable.description,
        causality=str(variable.causality),
    )


def _column(name: str, signal: Signal | PacketFact, interfaces: Mapping[str, Interface]) -> Column:
    if isinstance(signal, PacketFact):
        return Column(name=name, unit=None, is_float=False, description=_FACTS[signal.name])
    variable = interfaces[signal.component].variables[signal.variable]
    items = tuple((value, item) for item, value in (variable.items or {}).items())
    return Column(
        name=name,
        unit=variable.unit,
        is_float=variable.type.is_float,
        description=variable.description,
        causality=str(variable.causality),
        items=items,
        meaning=variable.meaning_of(signal.index),
        belongs_to=variable.slot_of(signal.index),
    )
