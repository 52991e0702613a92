"""``report.html`` of a run folder: facts, verdicts, the scene as an animation, every signal.

Everything is in the one file; it loads nothing from anywhere.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from cosim.plot.page.bundle import bundle
from cosim.record.digest import digest
from cosim.record.reader import Run
from cosim.record.statistics import ColumnSummary
from cosim.report.page.contents import contents
from cosim.report.page.foretold import foretold_notes, foretold_rows
from cosim.report.page.stations import station_table
from cosim.report.page.tables import (
    channel_table,
    deadline_table,
    energy_rows,
    measure_rows,
    provenance_rows,
    saturation_rows,
    verdict_rows,
)
from cosim.report.summary import numbers, outcome
from cosim.theory.stability.told import ToldLoop

HERE = Path(__file__).parent
LIVE = HERE.parents[1] / "live" / "page"
"""The live page, whose scene, colours and plots these are."""
MODULES = (
    LIVE / "vendor" / "uPlot.js",
    LIVE / "theme.js",
    LIVE / "scene.js",
    HERE / "report.js",
)
STYLES = (LIVE / "vendor" / "uPlot.css", LIVE / "style.css", HERE / "report.css")
VALUE = re.compile(r"[-−]?[\d.]+(e[-+]?\d+)? \S+")
BREAKS = re.compile(r"(?<=[._/\]])(?=[A-Za-z])")


def write_page(
    run: Run,
    path: Path,
    content: Mapping[str, Any],
    summaries: Mapping[str, ColumnSummary],
    scene: Mapping[str, Any] | None = None,
    *,
    told: Sequence[ToldLoop] = (),
) -> None:
    """Write the page of a run.

    Args:
        run: the record, open, with its manifest.
        path: the file to write.
        content: the run's summary (``cosim.report.summary``).
        summaries: statistics and envelope of each signal, by name.
        scene: what can be drawn of the run, where there is anything.
        told: what the theory says of the scenario.
    """
    jinja: Any = import_module("jinja2")
    markup: Any = import_module("markupsafe").Markup
    environment = jinja.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"breakable": _breakable, "together": _together}
    template = environment.from_string((HERE / "report.html.j2").read_text(encoding="utf-8"))
    data = json.dumps(contents(run, summaries, scene), allow_nan=False, separators=(",", ":"))
    notes = [*run.manifest.get("notes", ()), *_warnings(content)]
    page = template.render(
        title=content["title"] or content["scenario"] or run.folder.name,
        lead=numbers(content),
        outcome=outcome(content),
        status=content["status"],
        failures=[*content["failures"], *content["runaways"]],
        verdicts=verdict_rows(content),
        measures=measure_rows(content),
        theory=foretold_rows(told, run),
        theory_notes=foretold_notes(told),
        channels=channel_table(content),
        deadlines=deadline_table(content),
        stations=station_table(run.manifest),
        saturation=saturation_rows(run, scene),
        energies=energy_rows(run, summaries),
        notes=notes,
        ran=provenance_rows(run, digest(run)),
        scenario=run.scenario_yaml,
        # Nothing in data may close the element that it stands in.
        data=markup(data.replace("<", "\\u003c")),
        script=markup(bundle(MODULES).replace("</script", "<\\/script")),
        style=markup("\n".join(file.read_text(encoding="utf-8") for file in STYLES)),
    )
    path.write_text(page, encoding="utf-8")


def _breakable(text: object) -> Any:
    """A name that a narrow page may break behind its dots and strokes, and nowhere else."""
    safe: Any = import_module("markupsafe")
    return safe.Markup(BREAKS.sub("<wbr>", str(safe.escape(text))))


def _together(text: object) -> Any:
    """A number stays beside its unit; all else may be broken where it has room to be."""
    safe: Any = import_module("markupsafe")
    cell = str(text)
    return safe.escape(cell.replace(" ", "\u00a0") if VALUE.fullmatch(cell) else cell)


def _warnings(content: Mapping[str, Any]) -> list[str]:
    return [
        f"{name}: {value}" if not isinstance(value, dict) else f"{name}: {json.dumps(value)}"
        for name, value in content["warnings"].items()
    ]
