"""``cohaptic run system.ssp``: the scenario that a system structure describes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cosim.base.errors import InputError

if TYPE_CHECKING:
    from cosim.scenario import Scenario


def document_of(
    given: str, stop_time: str | None, start: Fraction | None = None
) -> tuple[dict[str, Any], list[str]]:
    """The scenario's document, and what is worth telling; ``start`` (s) is given or the system's.

    Raises:
        InputError: it cannot be read, or uses what cannot be used here.
    """
    from cosim.cli.support.fmu.alone import seconds
    from cosim.ssp.package import is_system, read_system

    if not is_system(given):
        raise InputError(f"{given} is no system: an .ssp, an .ssd or an OspSystemStructure.xml.")
    duration = None if stop_time is None else seconds(stop_time, "--stop-time")
    return read_system(Path(given), duration, start)


def scenario_of_system(
    given: str, *, stop_time: str | None, sets: Sequence[str], say: Callable[[str], None]
) -> Scenario:
    """The scenario, with overrides over it.

    Raises:
        InputError: as ``document_of``; or the scenario cannot be run.
    """
    from cosim.base.document.plain_name import plain_name
    from cosim.base.document.yaml_reader import parse_yaml
    from cosim.base.document.yaml_writer import write_yaml
    from cosim.cli.support.fmu.alone import begin_of
    from cosim.reading import FORMS
    from cosim.scenario.load import Written

    begin, sets = begin_of(sets)
    document, notes = document_of(given, stop_time, begin)
    for note in notes:
        say(f"note: {note}")
    path = Path(given).expanduser().absolute()
    document.setdefault("name", plain_name(path.stem) or "system")
    root = parse_yaml(write_yaml(document), str(path), has_lines=False)
    scenario = Written(path, root, FORMS).changed(sets).built()
    end = scenario.ticks / scenario.base_rate
    if end != scenario.duration:
        say(
            f"note: {float(scenario.duration):g} s are no whole number of ticks; the run ends at "
            f"{float(scenario.start_time + end):g} s"
        )
    return scenario
