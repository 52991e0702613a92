"""What a shell offers after Tab: scenarios, folders of runs, and the signals recorded in them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

SCENARIOS = (".yaml", ".yml", ".fmu", ".ssp", ".ssd")


def scenario_names(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Bundled scenarios, then files that may be one, and folders on the way to them."""
    from click.shell_completion import CompletionItem

    from cosim.scenario.source.bundled import bundled_scenarios

    del ctx, param
    bundled = [
        CompletionItem(each.name, help=each.title)
        for each in bundled_scenarios()
        if each.name.startswith(incomplete)
    ]
    return bundled + _paths(incomplete, SCENARIOS)


def run_folders(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Folders that hold a record, and folders on the way to them."""
    del ctx, param
    return _paths(incomplete, ())


def runs_and_signals(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Folders of runs, and the signals of those that stand there already."""
    from click.shell_completion import CompletionItem

    from cosim.base.errors import CohapticError
    from cosim.record.reader import open_run

    named = ctx.params.get(param.name or "") or ()
    found: dict[str, None] = {}
    for place in (each for each in named if Path(each).is_dir()):
        try:
            with open_run(place) as run:
                found |= dict.fromkeys(run.signals)
        except CohapticError:
            continue
    signals = [CompletionItem(name) for name in found if name.startswith(incomplete)]
    return signals + _paths(incomplete, ())


def _paths(incomplete: str, suffixes: tuple[str, ...]) -> list[CompletionItem]:
    """Files with one of the suffixes and all folders, as the shell would name them."""
    from click.shell_completion import CompletionItem

    folder, _, begun = incomplete.rpartition("/")
    place = Path(f"{folder}/" if folder or incomplete.startswith("/") else ".")
    try:
        entries = sorted(place.iterdir())
    except OSError:
        return []
    prefix = incomplete[: len(incomplete) - len(begun)]
    return [
        CompletionItem(f"{prefix}{each.name}{'/' if each.is_dir() else ''}")
        for each in entries
        if each.name.startswith(begun)
        and (each.is_dir() or each.suffix in suffixes)
        and (begun.startswith(".") or not each.name.startswith("."))
    ]
