"""From a scenario to everything that a run needs, with every problem reported at once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

from cosim.base.component import Causality, Component
from cosim.base.document.problems import Problems
from cosim.base.recording import RecordGroup
from cosim.master.assembly.clock import Clock
from cosim.master.assembly.connections import wire
from cosim.master.assembly.copies import differing_copies
from cosim.master.assembly.files import with_files
from cosim.master.assembly.knobs import Knobs
from cosim.master.assembly.layout import Layout, lay_out
from cosim.master.assembly.plan import Part, Plan, Planner
from cosim.master.assembly.rates import follow_rates
from cosim.master.assembly.selection import describe_groups, select_recorded
from cosim.master.assembly.turned import read_knobs
from cosim.master.assembly.wiring import Signal, Wiring
from cosim.master.components.isolation import isolate
from cosim.master.components.participant import Factory, Participant
from cosim.master.components.participants import notes_of, read_participants
from cosim.scenario import Kind, Scenario

Only = Callable[[Sequence[RecordGroup]], Collection[str]]
"""Told what would be recorded; says which signals are."""


@dataclass(frozen=True)  # no slots: see ``cosim.base.changed``
class Assembly:
    """A scenario, read, checked, wired, planned and laid out; nothing has run yet."""

    scenario: Scenario
    clock: Clock
    participants: Mapping[str, Participant]
    parts: Mapping[str, Part]
    wiring: Wiring
    knobs: Knobs
    plan: Plan
    layout: Layout
    groups: tuple[RecordGroup, ...]
    columns: tuple[tuple[int, ...], ...]
    """The recorded cells of each group."""
    text_columns: tuple[tuple[int, ...], ...]
    """The same of its texts."""
    lagging: tuple[str, ...]
    notes: tuple[str, ...]
    asked: Scenario
    """What it was made of; ``scenario`` has absolute names of files, and values from the rates."""


def put_together(
    scenario: Scenario,
    instances: Mapping[str, Component] | None = None,
    kinds: Mapping[Kind, Factory] | None = None,
    only: Only | None = None,
) -> Assembly:
    """Read every component, resolve every connection, order everything.

    ``instances`` holds components that exist already, by name; ``kinds`` makes those of kinds that
    the master does not know, such as playback. ``only`` chooses among what the scenario records.

    Raises:
        InputError: a problem, or ``InputErrors`` for several, each with its place.
    """
    asked, problems = scenario, Problems(scenario.root)
    clock = Clock(scenario.base_rate, scenario.start_tick)
    participants = read_participants(scenario, clock, problems, instances, kinds)
    isolated = isolate(participants, scenario)
    scenario = with_files(scenario, participants)
    of_rates = follow_rates(scenario, participants, problems)
    knobs = read_knobs(scenario, participants, problems)
    interfaces = {name: each.interface for name, each in participants.items()} | knobs.channels
    wiring = wire(scenario, interfaces, knobs, problems)
    selected = select_recorded(scenario, interfaces, wiring, problems)
    problems.raise_if_any()
    if only is not None:
        names = only(describe_groups(scenario, interfaces, selected))
        chosen = [group.only(names) for group in selected]
        selected = [group for group in chosen if group.signals or group.texts]

    parts = {
        name: Part(each.interface, each.period, each.fmu is not None, each.methods, each.played)
        for name, each in participants.items()
    }
    recorded = {signal for group in selected for signal in group.read}
    outputs, local = _read_variables(participants, wiring, recorded)
    planner = Planner(
        parts,
        wiring,
        outputs,
        local,
        tuple(group.period for group in selected),
        knobs.dials(),
    )
    with problems.at(("connections",)):
        plan = planner.plan()
        clock.hyperperiod(action.period for action in plan.every)
        variables = {name: knob.variable for name, knob in knobs.all.items()}
        layout = lay_out(parts, wiring, plan, variables)
        return Assembly(
            scenario=scenario,
            clock=clock,
            participants=participants,
            parts=parts,
            wiring=wiring,
            knobs=knobs,
            plan=plan,
            layout=layout,
            groups=tuple(describe_groups(scenario, interfaces, selected)),
            columns=tuple(
                tuple(layout.of(signal) for signal in group.signals.values()) for group in selected
            ),
            text_columns=tuple(
                tuple(layout.of(signal) for signal in group.texts.values()) for group in selected
            ),
            lagging=tuple(planner.lagging()),
            notes=(
                *wiring.notes,
                *of_rates,
                *differing_copies(scenario, participants),
                *notes_of(participants),
                *isolated,
            ),
            asked=asked,
        )
    problems.raise_if_any()
    raise AssertionError


def _read_variables(
    participants: Mapping[str, Participant], wiring: Wiring, recorded: set[Signal]
) -> tuple[dict[str, tuple[str, ...]], dict[str, tuple[str, ...]]]:
    """The outputs that somebody reads, and what else is read only to be recorded."""
    sources = {w.source for w in wiring.wires if isinstance(w.source, Signal)}
    for bundle in wiring.bundles:
        sources |= {e.source for e in bundle.entries if isinstance(e.source, Signal)}
    outputs: dict[str, set[str]] = {}
    local: dict[str, set[str]] = {}
    for signal in sources | recorded:
        if signal.component not in participants:
            continue  # a dial of a channel
        interface = participants[signal.component].interface
        causality = interface.variables[signal.variable].causality
        if causality is Causality.INPUT or signal.variable in interface.knobs:
            continue
        # An FMU without feedthrough is read before its inputs are set, whatever is read.
        early = causality is Causality.OUTPUT or not interface.feedthrough
        (outputs if early else local).setdefault(signal.component, set()).add(signal.variable)
    return (
        {name: tuple(sorted(names)) for name, names in outputs.items()},
        {name: tuple(sorted(names)) for name, names in local.items()},
    )
