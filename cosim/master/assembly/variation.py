"""The same plan with other values: what a sweep changes from run to run without assembling again.

Parameters and start values, the seed, what happens to packets, the duration and the expectations
leave order, cells and wires as they are, unless a packet may now arrive in the tick in which it was
sent, or no longer may. Everything else is another plan.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from operator import attrgetter, is_

from cosim.base.changed import changed as with_members
from cosim.base.document.problems import Problems
from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.files import with_files
from cosim.master.assembly.knobs import Knobs
from cosim.master.assembly.rates import follow_rates
from cosim.master.assembly.turned import read_knobs
from cosim.master.assembly.wiring import Bundle, Wiring
from cosim.master.channels.fates import Fates
from cosim.master.components.participant import Participant
from cosim.master.components.participants import other_values
from cosim.scenario import Channel, Direction, Scenario, ScenarioComponent

_all_but_the_seed = attrgetter(*(m.name for m in fields(Scenario) if m.name != "seed"))
_all_but_values = attrgetter(
    *(m.name for m in fields(ScenarioComponent) if m.name not in {"parameters", "start"})
)
_STRUCTURE = ("base_rate", "start_tick", "rates", "record")


def with_values(assembly: Assembly, scenario: Scenario) -> Assembly | None:
    """An assembly of ``scenario`` that shares the plan, or ``None`` where it may have another.

    Notes are those of the assembly that it comes from.

    Raises:
        InputError: a value cannot be used, or ``InputErrors`` for several, each with its place.
    """
    asked, channels = scenario, scenario.channels
    if all(map(is_, _all_but_the_seed(assembly.asked), _all_but_the_seed(scenario))):
        return _with_seed(assembly, scenario)
    before = assembly.scenario
    if any(getattr(before, name) != getattr(scenario, name) for name in _STRUCTURE):
        return None
    if before.knobs != scenario.knobs or _turned(before) != _turned(scenario):
        return None
    changed = _changed(before, scenario)
    if changed is None:
        return None
    problems = Problems(scenario.root)
    participants = dict(assembly.participants)
    others: dict[str, Participant] = {}
    for name in changed:
        with problems.at(("components", name)):
            old, new = before.components[name], scenario.components[name]
            participant = other_values(participants[name], old, new, problems)
            if participant is None:
                return None
            others[name] = participant
    participants |= others
    if scenario.ticks != before.ticks:
        for name, participant in participants.items():
            with problems.at(("components", name)):
                assembly.clock.check_exact(scenario.ticks, participant.substeps, name)
    if others:
        # Names of files are absolute in an assembled scenario; the others' are so already.
        kept = {n: before.components[n] for n in scenario.components if n not in others}
        scenario = with_files(scenario, others)
        scenario = with_members(scenario, components={**scenario.components, **kept})
        follow_rates(scenario, others, problems)
    elif scenario.components is not before.components:
        scenario = with_members(scenario, components=before.components)
    knobs = Knobs(scenario, participants)
    if assembly.knobs.all:
        knobs = read_knobs(scenario, participants, problems)
    problems.raise_if_any()
    wiring = assembly.wiring
    if assembly.knobs.all or scenario.seed != before.seed or channels is not before.channels:
        bundles = _bundles(wiring, scenario, knobs)
        if bundles is None or knobs.ranges() != assembly.knobs.ranges():
            return None
        wiring = Wiring(wiring.wires, bundles, wiring.notes, wiring.connection_of)
    return with_members(
        assembly,
        scenario=scenario,
        participants=participants,
        knobs=knobs,
        wiring=wiring,
        asked=asked,
    )


def _with_seed(assembly: Assembly, asked: Scenario) -> Assembly:
    """The assembly of a scenario that has another seed, and nothing else: the quick way."""
    wiring = assembly.wiring
    bundles = [
        each if each.channel is None else _drawn_anew(each, asked.seed) for each in wiring.bundles
    ]
    return with_members(
        assembly,
        scenario=with_members(assembly.scenario, seed=asked.seed),
        wiring=Wiring(wiring.wires, bundles, wiring.notes, wiring.connection_of),
        asked=asked,
    )


def _drawn_anew(bundle: Bundle, seed: int) -> Bundle:
    fates = bundle.fates
    return _with_fates(bundle, fates.again(seed, fates.direction, fates.extremes))


def _with_fates(one: Bundle, fates: Fates) -> Bundle:
    return Bundle(one.name, one.channel, one.way, one.period, fates, one.entries)


def _changed(before: Scenario, after: Scenario) -> list[str] | None:
    """The components that have other values; ``None`` where more than that is different."""
    if list(before.components) != list(after.components):
        return None
    if before.channels is not after.channels and _ways(before) != _ways(after):
        return None
    if before.connections is not after.connections and before.connections != after.connections:
        return None
    changed: list[str] = []
    for name, old in before.components.items():
        new = after.components[name]
        if new is old:
            continue
        if _all_but_values(old) != _all_but_values(new):
            return None
        if _values(old) != _values(new):
            changed.append(name)
    return changed


def _ways(scenario: Scenario) -> list[Channel]:
    """The channels without what happens to their packets."""
    nothing = Direction()
    return [replace(each, forward=nothing, backward=nothing) for each in scenario.channels.values()]


def _turned(scenario: Scenario) -> set[str]:
    """What events turn: it has cells, and is recorded."""
    return {str(event.target) for event in scenario.events}


def _values(component: ScenarioComponent) -> tuple[Mapping[str, object], Mapping[str, object]]:
    return component.parameters, component.start


def _bundles(wiring: Wiring, scenario: Scenario, knobs: Knobs) -> list[Bundle] | None:
    """The bundles with the fates that the scenario gives them; ``None`` for another order."""
    bundles: list[Bundle] = []
    for bundle in wiring.bundles:
        if bundle.channel is None:
            bundles.append(bundle)
            continue
        channel = scenario.channels[bundle.channel]
        direction = channel.forward if bundle.way == "forward" else channel.backward
        extremes = knobs.extremes(channel.name, bundle.way)
        fates = bundle.fates.again(scenario.seed, direction, extremes)
        other = _with_fates(bundle, fates)
        if not fates.has_ways_of(bundle.fates) and (
            other.can_be_immediate != bundle.can_be_immediate
        ):
            return None
        bundles.append(other)
    return bundles
