"""The document resolved into a :class:`Scenario`: names looked up, times in ticks, all checked."""

from __future__ import annotations

from fractions import Fraction
from math import ceil, floor
from pathlib import Path

from cosim.base.document.node import Node, PathKey
from cosim.base.document.problems import Problems
from cosim.base.suggest import did_you_mean
from cosim.scenario.build.channel import ChannelProblem, directions
from cosim.scenario.build.component import build_component
from cosim.scenario.build.connection import build_connection, check_signal
from cosim.scenario.build.context import Context
from cosim.scenario.build.timebase import Timebase, check_base_rate, choose_base_rate, hertz
from cosim.scenario.build.turning import build_events, build_knobs
from cosim.scenario.build.validated import validated
from cosim.scenario.form.document import document_form
from cosim.scenario.form.sections import Forms, plain, written_in
from cosim.scenario.model import Channel, Connection, Record, Scenario, ScenarioComponent
from cosim.scenario.presets import PRESETS
from cosim.scenario.source.notation import components_in


def build(root: Node, file: Path, forms: Forms | None = None) -> Scenario:
    """Check and resolve a merged document.

    Raises:
        InputError: everything that is wrong with it.
    """
    assert isinstance(root.value, dict)
    members = {key: node for key, node in root.value.items() if not key.startswith("x-")}
    root = Node(members, root.place, root.key_place, root.removed)
    form = document_form(written_in(root, forms or {}))
    problems = Problems(root, form, "the scenario")
    context = validated(root, problems, form)
    document = context.document
    timebase = _timebase(context)
    context.timebase = timebase
    _check_names(context)
    components = _components(context)
    channels = _channels(context, components)
    connections = _connections(context, components, channels)
    knobs = build_knobs(context, channels)
    start_tick = _start_tick(context)
    events = build_events(context, channels, timebase.ticks(document.duration), start_tick)
    record = _record(context)
    for signal in document.expect:
        for component in components_in(signal):
            check_signal(context, ("expect", signal), component)
    problems.raise_if_any()
    return Scenario(
        cohaptic=document.cohaptic,
        name=document.name or _name_of(file),
        file=file,
        title=document.title,
        description=document.description,
        duration=document.duration,
        ticks=timebase.ticks(document.duration),
        start_tick=start_tick,
        base_rate=timebase.base_rate,
        seed=document.seed,
        rates=document.rates,
        components=components,
        channels=channels,
        connections=connections,
        knobs=knobs,
        events=events,
        record=record,
        expect={signal: plain(conditions) for signal, conditions in document.expect.items()},
        safety=plain(document.safety),
        realtime=plain(document.realtime),
        link=plain(document.link),
        root=root,
    )


def _timebase(context: Context) -> Timebase:
    """The base tick from every rate that occurs, named or not."""
    rates, paths = _all_rates(context)
    base = context.document.base_rate
    if not rates:
        return Timebase(base or Fraction(1))
    if base is None:
        timebase, refused = choose_base_rate(rates)
    else:
        timebase, refused = Timebase(base), check_base_rate(base, rates)
    for label, sentence in refused.items():
        context.problems.add(paths[label], sentence)
    context.refused = {rates[label] for label in refused}
    return timebase


def _start_tick(context: Context) -> int:
    """The first tick, which is one of those that count from time 0."""
    start, base_rate = context.document.start_time, context.timebase.base_rate
    ticks = start * base_rate
    if ticks.denominator != 1:
        near = " or ".join(
            f"{float(tick / base_rate):.12g} s" for tick in (floor(ticks), ceil(ticks))
        )
        context.problems.add(
            ("start_time",),
            f"start_time: {float(start):g} s lies between two base ticks; write {near}.",
        )
    return floor(ticks)


def _all_rates(
    context: Context,
) -> tuple[dict[str, Fraction], dict[str, tuple[PathKey, ...]]]:
    """Every rate by a label for messages, and where it is written."""
    document = context.document
    rates: dict[str, Fraction] = {}
    paths: dict[str, tuple[PathKey, ...]] = {}

    def add(label: str, rate: Fraction | str | None, path: tuple[PathKey, ...]) -> None:
        if isinstance(rate, Fraction):
            rates[f"{label} ({hertz(rate)})"] = rate
            paths[f"{label} ({hertz(rate)})"] = path

    for name, rate in document.rates.items():
        add(f"the rate {name}", rate, ("rates", name))
    for section in ("components", "channels"):
        for name, form in getattr(document, section).items():
            add(f"the rate of {name}", form.rate, (section, name, "rate"))
    for position, form in enumerate(document.connections):
        index = context.index("connections", position)
        add(f"the rate of connection {index}", form.rate, ("connections", index, "rate"))
    for position, entry in enumerate(document.record):
        if not isinstance(entry, str):
            index = context.index("record", position)
            add(f"the rate of record {index}", entry.rate, ("record", index, "rate"))
    return rates, paths


def _check_names(context: Context) -> None:
    names = context.names("components")
    if not names and context.is_whole("components"):
        context.problems.add(("components",), "a scenario needs at least one component.")
    for name in context.names("channels"):
        if name in names:
            context.problems.add(
                ("channels", name), f"'{name}' is a component already.", at_key=True
            )


def _components(context: Context) -> dict[str, ScenarioComponent]:
    built = {
        name: build_component(context, name, form)
        for name, form in context.document.components.items()
    }
    return {
        name: component
        for name, component in built.items()
        if component is not None and ("components", name) not in context.doubtful
    }


def _channels(context: Context, components: dict[str, ScenarioComponent]) -> dict[str, Channel]:
    known = {part.station for part in components.values()}
    complete = len(known) > 0 and len(components) == len(context.names("components"))
    channels: dict[str, Channel] = {}
    for name, form in context.document.channels.items():
        path = ("channels", name)
        first, second = form.between
        unknown = [end for end, station in enumerate(form.between) if station not in known]
        if first == second:
            context.problems.add((*path, "between"), f"both ends are the station {first}.")
        for end in unknown if complete else ():
            hint = did_you_mean(form.between[end], known)
            message = f"no component is in the station '{form.between[end]}'.{hint}"
            context.problems.add((*path, "between", end), message)
        rate = context.rate(form.rate, path)
        if rate is None or rate in context.refused or first == second or (unknown and complete):
            continue
        period = context.timebase.period(rate)
        try:
            forward, backward = directions(
                form, context.timebase, period, lambda key, path=path: context.folder((*path, key))
            )
        except ChannelProblem as error:
            context.problems.add((*path, error.key), f"{'.'.join((*path, error.key))}: {error}")
            continue
        channels[name] = Channel(
            name=name,
            between=(first, second),
            rate_name=context.rate_name(form.rate),
            rate=rate,
            period=period,
            forward=forward,
            backward=backward,
            options=plain(form.link),
        )
    return channels


def _connections(
    context: Context, components: dict[str, ScenarioComponent], channels: dict[str, Channel]
) -> tuple[Connection, ...]:
    built: list[Connection] = []
    places: dict[str, int] = {}
    for position, form in enumerate(context.document.connections):
        index = context.index("connections", position)
        if str(form.target) in places:
            first = context.root.locate(("connections", places[str(form.target)]))
            message = f"a second connection into {form.target}; the first is at {first}."
            context.problems.add(("connections", index, "to"), message)
        places.setdefault(str(form.target), index)
        connection = build_connection(context, index, form, components, channels)
        if connection is not None:
            built.append(connection)
    return tuple(built)


def _record(context: Context) -> tuple[Record, ...]:
    records: list[Record] = []
    for position, entry in enumerate(context.document.record):
        index = context.index("record", position)
        pattern = entry if isinstance(entry, str) else entry.signals
        rate = None
        if not isinstance(entry, str) and entry.rate is not None:
            rate = context.rate(entry.rate, ("record", index))
        if pattern not in PRESETS:
            check_signal(context, ("record", index), pattern.partition(".")[0])
        fits = rate is not None and rate not in context.refused
        period = context.timebase.period(rate) if rate is not None and fits else None
        records.append(Record(pattern=pattern, rate=rate, period=period))
    return tuple(records)


def _name_of(file: Path) -> str:
    """A name made of the file's: what is no letter, digit or '_' becomes '_'."""
    stem = "".join(c if c.isascii() and (c.isalnum() or c == "_") else "_" for c in file.stem)
    return stem if stem[:1].isalpha() else f"scenario_{stem}"
