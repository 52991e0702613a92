"""From a scenario to a run that may begin, or to every reason why it may not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from cosim.base.component import Component
from cosim.base.document.problems import Problems
from cosim.master.run.simulation import Simulation, assemble
from cosim.master.run.whereabouts import Whereabouts
from cosim.preparation.late_packets import packets_that_come_too_late
from cosim.preparation.room import room_for_the_record
from cosim.record.playback import KINDS
from cosim.report.expectation import Expectation
from cosim.report.verdict.reading import parse_expectations
from cosim.scenario import Scenario

Judge = Callable[[Scenario, Simulation], list[str]]
"""Looks at what is not the master's (devices): returns warnings, raises ``InputError``."""


@dataclass(frozen=True, slots=True)
class Prepared:
    """A run that may begin; closing it closes its components."""

    simulation: Simulation
    expectations: tuple[Expectation, ...]
    warnings: tuple[str, ...]
    """What is allowed and probably not meant."""


def prepare(
    scenario: Scenario,
    folder: Path | None = None,
    *,
    instances: Mapping[str, Component] | None = None,
    judge: Judge | None = None,
    recorded: bool = True,
    whereabouts: Whereabouts | None = None,
) -> Prepared:
    """Read, check, wire and plan a scenario, and judge all that a run of it would refuse.

    Nothing has been started and nothing is opened or written. ``folder`` is where the record would
    go, if it is ``recorded``; ``instances`` holds components that exist already, by
    name, ``whereabouts`` is where the run will say what it does.

    Raises:
        InputError: a problem, or ``InputErrors`` for several, each with its place.
    """
    problems = Problems(scenario.root)
    _judge_links(scenario, problems)
    assembled: list[Simulation] = []
    with problems.at(("components",)):
        assembled.append(assemble(scenario, instances, KINDS, whereabouts))
    if not assembled:  # what else there is to say needs the assembled scenario
        problems.raise_if_any()
    (simulation,) = assembled
    expectations: list[Expectation] = []
    warnings: list[str] = []
    try:
        with problems.at(("expect",)):
            expectations = parse_expectations(scenario, simulation.groups)
        with problems.at(("record",)):
            warnings += room_for_the_record(simulation, folder) if recorded else []
        with problems.at(("components",)):
            warnings += [] if judge is None else judge(scenario, simulation)
        warnings += packets_that_come_too_late(scenario)
        problems.raise_if_any()
    except BaseException:
        simulation.close()
        raise
    return Prepared(simulation, tuple(expectations), tuple(warnings))


def _judge_links(scenario: Scenario, problems: Problems) -> None:
    """The ``link:`` settings, of the scenario and with those of each channel over them."""
    if not scenario.link and not any(channel.options for channel in scenario.channels.values()):
        return
    from cosim.link.stream.form import read_link

    with problems.at(("link",)):
        read_link(scenario.link, "link")
        for name, channel in scenario.channels.items():
            with problems.at(("channels", name, "link")):
                read_link({**scenario.link, **channel.options}, f"channel {name}")
