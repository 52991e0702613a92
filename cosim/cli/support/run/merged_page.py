"""The page of a merged run: the scenes of all stations in one, and what either station measured."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cosim.base.errors import CohapticError

if TYPE_CHECKING:
    from cosim.record.reader import Run
    from cosim.theory.stability.told import ToldLoop


def write_merged_page(run: Run, stations: Iterable[Path]) -> Path:
    """Make ``report.html`` of a merged run, as it is made of every other.

    Args:
        run: the merged record, open.
        stations: the folders that it was merged from.
    """
    from cosim.base.system.writing import writing
    from cosim.record.scene import SCENE_FILE, read_scene
    from cosim.report.drawings import REPORT_FILE, Drawings
    from cosim.report.summary import summarise

    summaries = {name: signal.summary() for name, signal in run.signals.items()}
    content = summarise(run, (), summaries).content
    scene = joined(read_scene(folder) for folder in stations)
    drawings = Drawings(figure=False, page=True, scene=scene, theory=lambda: _theory(run))
    for name, write in drawings.files(run, content, summaries).items():
        if name in {REPORT_FILE, SCENE_FILE}:
            with writing(run.folder / name):
                write(run.folder / name)
    return run.folder / REPORT_FILE


def joined(scenes: Iterable[Mapping[str, Any] | None]) -> dict[str, Any]:
    """One scene of several: what each has of every kind, equal things once."""
    found: dict[str, list[Any]] = {}
    for scene in scenes:
        for kind, things in (scene or {}).items():
            kept = found.setdefault(kind, [])
            kept += [thing for thing in things if thing not in kept]
    return found


def _theory(run: Run) -> Sequence[ToldLoop]:
    """Of the whole scenario, which lies beside the record where the stations agreed on one."""
    from cosim.analysis.worlds import tell_of
    from cosim.reading import load
    from cosim.record.reader import SCENARIO_FILE
    from cosim.theory.stability.told import ToldLoop

    file = run.folder / SCENARIO_FILE
    if not file.exists():
        missing = "The stations' folders hold no scenario that both agreed on."
        return (ToldLoop("", refusal=missing),)
    try:
        return tell_of(load(str(file), (), ()))
    except CohapticError as error:
        # A component of a laboratory's own may be missing where the records are looked at.
        return (ToldLoop("", refusal=f"{SCENARIO_FILE} cannot be read here: {error}"),)
