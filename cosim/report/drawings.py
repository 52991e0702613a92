"""What is drawn of a run when it has ended: an overview, a page, and the scene as both need it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cosim.record.reader import Run
from cosim.record.scene import SCENE_FILE
from cosim.record.statistics import ColumnSummary
from cosim.report.summary import facts

if TYPE_CHECKING:
    from cosim.theory.stability.told import ToldLoop

FIGURE_FILE = "overview.png"
REPORT_FILE = "report.html"

Write = Callable[[Path], None]


@dataclass(frozen=True, slots=True)
class Drawings:
    """Which files a run leaves beside its record.

    Attributes:
        figure: whether there is an overview.
        page: whether there is a page.
        scene: what can be drawn of the run (``cosim.scene``).
        theory: asked for what the theory says of the scenario, where a page is made.
    """

    figure: bool
    page: bool
    scene: Mapping[str, Any] | None = None
    theory: Callable[[], Sequence[ToldLoop]] | None = None

    def files(
        self, run: Run, content: Mapping[str, Any], summaries: Mapping[str, ColumnSummary]
    ) -> dict[str, Write]:
        """By name what writes each file; nothing is drawn yet.

        Args:
            run: the record, open.
            content: the run's summary.
            summaries: statistics and envelope of each signal, by name.
        """
        found: dict[str, Write] = {}
        scene = self.scene if self.scene is not None and has_things(self.scene) else None
        if scene is not None:
            text = json.dumps(scene, indent=1) + "\n"
            found[SCENE_FILE] = lambda path: _write_text(path, text)
        if self.figure:
            found[FIGURE_FILE] = lambda path: _draw(run, path, summaries, facts(content))
        if self.page:
            found[REPORT_FILE] = lambda path: self._write_page(run, path, content, summaries)
        return found

    def _write_page(
        self,
        run: Run,
        path: Path,
        content: Mapping[str, Any],
        summaries: Mapping[str, ColumnSummary],
    ) -> None:
        from cosim.report.page.document import write_page

        scene = self.scene if self.scene is not None and has_things(self.scene) else None
        told = self.theory() if self.theory else ()
        write_page(run, path, content, summaries, scene, told=told)


def has_things(scene: Mapping[str, Any]) -> bool:
    """Whether there is anything in a scene that moves."""
    return any(scene.get(kind) for kind in ("boxes", "fingers", "bodies"))


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _draw(run: Run, path: Path, summaries: Mapping[str, ColumnSummary], line: str) -> None:
    from cosim.report.overview import draw_overview

    draw_overview(run, path, summaries, line)
