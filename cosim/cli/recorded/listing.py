"""``cohaptic runs``: which runs there are, and which of them have a value."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import click

from cosim.base.errors import InputError
from cosim.cli.recorded.conditions import STATUS, Condition
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.complete import run_folders


@click.command("runs", cls=JsonCommand)
@click.argument(
    "folder", default="runs", type=click.Path(path_type=Path), shell_complete=run_folders
)
@click.option(
    "--where",
    multiple=True,
    metavar="NAME=VALUE",
    help="Only runs of which this holds; =, !=, <, >, <= and >= of a measure ('drift<2 mm'), of "
    "status (good, failed, refused), scenario, started or simulated_time, or of a place in the "
    "scenario (vr_a.mass=0.4, lan.loss>0), in SI units where none is named; may be repeated.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(folder: Path, *, where: tuple[str, ...], as_json: bool) -> None:
    """List the runs in FOLDER and below it, the newest last."""
    conditions = [Condition.read(text) for text in where]
    every = sorted(_runs(folder), key=lambda facts: facts["started"])
    held = [condition.holds(every, folder) for condition in conditions]
    found = [facts for facts, *each in zip(every, *held, strict=True) if all(each)]
    if as_json:
        click.echo(json.dumps({"runs": found}))
        return
    if not found:
        click.echo(f"no run in {folder}" + (" of which that holds" if where else ""))
        return
    endings = {status: word for word, status in STATUS.items()}
    rows = [("run", "scenario", "started", "time", "status", "")]
    rows += [
        (
            facts["folder"],
            facts["scenario"],
            facts["started"][:16].replace("T", " "),
            f"{facts['simulated_time']:g} s",
            endings.get(facts["status"], "refused"),
            facts["message"].splitlines()[0] if facts["message"] else "",
        )
        for facts in found
    ]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, [*widths, 0], strict=True)]
        click.echo("  ".join(cells).rstrip())


def _runs(folder: Path) -> Iterator[dict[str, Any]]:
    from cosim.record.reader import MANIFEST_FILE, read_manifest

    if not folder.is_dir():
        raise InputError(f"there is no folder {folder}.")
    for file in folder.rglob(MANIFEST_FILE):
        manifest = read_manifest(file.parent)
        if "scenario" in manifest:
            yield _facts(file.parent, manifest)


def _facts(folder: Path, manifest: Mapping[str, Any]) -> dict[str, Any]:
    from cosim.report.summary import read_summary

    summary = read_summary(folder)
    ended = manifest.get("exit") or {"status": 1, "message": "cut off, or still running"}
    content: Mapping[str, Any] = {} if summary is None else summary.content
    return {
        "folder": str(folder),
        "scenario": manifest["scenario"].get("name", ""),
        "started": manifest.get("started") or "",
        "simulated_time": content.get("simulated_time", 0.0),
        "status": content.get("status", ended["status"]),
        "message": content.get("message", ended["message"]),
        "measures": content.get("measures", {}),
        "failures": content.get("failures", []),
    }
