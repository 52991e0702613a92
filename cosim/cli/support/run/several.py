"""The scenarios of one call, one after another; each of them ends for itself."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cosim.base.errors import CohapticError, InputError
from cosim.cli.support.command import problems_of
from cosim.cli.support.effect import given_of
from cosim.cli.support.run.junit import RunEnd
from cosim.cli.support.run.one import RunOptions, read_one, run_one
from cosim.cli.support.terminal.journal import Journal, details

if TYPE_CHECKING:
    from cosim.scenario import Scenario


def run_each(
    written: Sequence[str | None], out: Path | None, options: RunOptions, journal: Journal
) -> Iterator[RunEnd]:
    """Run scenarios one after another; how each of them ended, as soon as it has.

    All are read before the first runs: where one cannot be, only these are in the answer. ``out``
    is the folder of a single one; of several the folder in which each gets its own, by name.

    Raises:
        InputError: an option is for a single one.
    """
    if len(written) > 1:
        given = {
            "--from": options.origin,
            "--live": options.live,
            "--foxglove": options.foxglove,
            "--live-at": options.live_at,
        }
        if named := given_of(given):
            raise InputError(f"{' and '.join(named)}: for one scenario; name a single one.")
    scenarios: list[Scenario] = []
    refused: list[RunEnd] = []
    for name in written:
        try:
            scenarios.append(read_one(name, options, journal.say))
        except InputError as error:
            refused.append(RunEnd(name or "run", None, error))
    if refused:
        yield from refused
        return
    folders = [out] if len(scenarios) == 1 else _folders(scenarios, out)
    for scenario, folder in zip(scenarios, folders, strict=True):
        yield _ended(scenario, folder, options, journal)


def answer(ends: Sequence[RunEnd], *, is_alone: bool) -> dict[str, Any]:
    """What ``--json`` prints: of a call with one scenario its summary, else all in ``runs``."""
    contents = [
        {"ok": False, "problems": problems_of(end.error)}
        if end.error is not None
        else dict(end.content or {})
        for end in ends
    ]
    return contents[0] if is_alone else {"runs": contents}


def _folders(scenarios: Sequence[Scenario], out: Path | None) -> list[Path | None]:
    if out is None:
        return [None] * len(scenarios)
    seen: Counter[str] = Counter()
    found: list[Path | None] = []
    for scenario in scenarios:
        seen[scenario.name] += 1
        number = seen[scenario.name]
        found.append(out / (scenario.name if number == 1 else f"{scenario.name}-{number}"))
    return found


def _ended(
    scenario: Scenario, folder: Path | None, options: RunOptions, journal: Journal
) -> RunEnd:
    from cosim.record.reader import read_manifest

    journal.detail(f"{scenario.name}: {scenario.ticks} ticks at {float(scenario.base_rate):g} Hz")
    try:
        finished = run_one(scenario, folder, options, journal.say)
    except CohapticError as error:
        return RunEnd(scenario.name, None, error)
    for line in details(read_manifest(finished.folder)):
        journal.detail(f"{scenario.name}: {line}")
    return RunEnd(scenario.name, finished.summary.content)
