"""One HTML page: each statement of the thesis beside what was measured, with the figures."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path

from cosim.thesis.claims.statement import Runs
from cosim.thesis.claims.verdict import Decided
from cosim.thesis.experiments import Ran
from cosim.thesis.pages.figures import FIGURES
from cosim.thesis.pages.findings import BeyondPart
from cosim.thesis.pages.phrases import command, origins
from cosim.thesis.pages.rows import rows

CAPTIONS = {
    "8.1": "Figure 8.1: grasp and carry, distributed against the remote user of the centralized "
    "controller, same couplers, one network sample of delay.",
    "8.3": "Figure 8.3: a sine of 0.05 m at 2 rad/s against a constant opposing force. The net "
    "force is what both fingers give together, each on its own copy of the box.",
    "8.4": "Figure 8.4: pushing the box against a stiff wall with the pushing halves of "
    "1.5 sin 3t N.",
    "7.4": "A finger hits the box at 0.3 m/s with a wall behind it, with and without the "
    "moment-cancellation state of figure 7.4.",
}


def write_page(
    path: Path,
    decided: Sequence[Decided],
    *,
    wanted: Runs,
    runs: Mapping[str, Ran],
    figures: Mapping[str, Path],
    beyond: BeyondPart | None = None,
) -> None:
    """Write the page; the figures are inside it, so that it can be sent around alone.

    ``wanted`` says how each of ``runs`` is run again; runs with a report beside the page are linked
    to. ``beyond`` is the second part, what lies past the thesis.
    """
    from jinja2 import Environment

    template = files("cosim.thesis.pages").joinpath("page.html.j2").read_text(encoding="utf-8")
    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    everything = [*decided, *(beyond.decided if beyond else ())]
    verdicts = [item.verdict for item in everything]
    reports = {
        name: f"{ran.folder.name}/report.html"
        for name, ran in runs.items()
        if ran.folder.parent == path.parent and (ran.folder / "report.html").exists()
    }
    html = environment.from_string(template).render(
        rows=rows,
        origins=origins,
        command=command,
        reports=reports,
        wanted=wanted,
        decided=decided,
        runs=runs,
        figures=[
            (CAPTIONS.get(name, name), _embedded(file), FIGURES[name][0])
            for name, file in figures.items()
        ],
        beyond=beyond and beyond.decided,
        findings=beyond.findings(_embedded) if beyond else (),
        counts={verdict: verdicts.count(verdict) for verdict in sorted(set(verdicts))},
    )
    path.write_text(html, encoding="utf-8")


def _embedded(file: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(file.read_bytes()).decode("ascii")
