"""``cohaptic runs``: which runs there are, and which of them have a value."""

from __future__ import annotations

import json
import operator
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand

COMPARISONS = (">=", "<=", "!=", "=", ">", "<")


@click.command("runs", cls=JsonCommand)
@click.argument("folder", default="runs", type=click.Path(path_type=Path))
@click.option(
    "--where",
    multiple=True,
    metavar="NAME=VALUE",
    help="Only runs of which this holds; =, !=, <, >, <= and >= of a measure (drift<0.002), of "
    "status or scenario, or of a place in the scenario (vr_a.mass=0.4, lan.loss>0); may be "
    "repeated.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(folder: Path, *, where: tuple[str, ...], as_json: bool) -> None:
    """List the runs in FOLDER and below it, the newest last."""
    conditions = [_condition(text) for text in where]
    found = [
        facts
        for facts in sorted(_runs(folder), key=lambda facts: facts["started"])
        if all(_holds(facts, *condition) for condition in conditions)
    ]
    if as_json:
        click.echo(json.dumps({"runs": found}))
        return
    if not found:
        click.echo(f"no run in {folder}" + (" of which that holds" if where else ""))
        return
    rows = [("run", "scenario", "started", "time", "status", "")]
    rows += [
        (
            facts["folder"],
            facts["scenario"],
            facts["started"][:16].replace("T", " "),
            f"{facts['simulated_time']:g} s",
            "good" if facts["status"] == 0 else "failed" if facts["status"] == 1 else "refused",
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


def _condition(text: str) -> tuple[str, str, str]:
    for sign in COMPARISONS:
        name, found, value = text.partition(sign)
        if found and name.strip() and value.strip():
            return name.strip(), sign, value.strip()
    raise InputError(f"--where {text}: write NAME=VALUE, such as drift<0.002 or vr_a.mass=0.4.")


def _holds(facts: Mapping[str, Any], name: str, sign: str, wanted: str) -> bool:
    if name in facts["measures"]:
        actual: Any = facts["measures"][name]
    elif name in {"scenario", "status", "started", "simulated_time"}:
        actual = facts[name]
    else:
        actual = _written(Path(facts["folder"]), name)
    if actual is None:
        return False
    try:
        return _compare(float(actual), sign, float(wanted))
    except (TypeError, ValueError):
        return _compare(str(actual), sign, wanted)


def _compare(one: Any, sign: str, other: Any) -> bool:
    holds = {
        "=": operator.eq,
        "!=": operator.ne,
        "<": operator.lt,
        ">": operator.gt,
        "<=": operator.le,
        ">=": operator.ge,
    }[sign]
    return bool(holds(one, other))


def _written(folder: Path, name: str) -> Any:
    """What stands at a place in the resolved scenario; ``None`` where nothing does."""
    from cosim.base.document.yaml_reader import parse_yaml
    from cosim.record.reader import SCENARIO_FILE

    file = folder / SCENARIO_FILE
    if not file.is_file():
        return None
    root = parse_yaml(file.read_text(encoding="utf-8"), str(file))
    first, _, rest = name.partition(".")
    for path in (
        name.split("."),
        ["components", first, "parameters", rest],
        ["components", first, *rest.split(".")],
        ["channels", first, *rest.split(".")],
    ):
        keys = tuple(path)
        node, depth = root.find(keys)
        if depth == len(keys) and not node.is_mapping:
            return node.plain()
    return None
