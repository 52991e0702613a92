"""The README's map of delay and stiffness: ``python -m tests.support.guide.stability_map``.

The sweeps that the README shows are run as they stand there, on every processor; what came out is
kept in ``docs/images/stability_map.json``, and drawn from there.
"""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from cosim.cli.sweep import command, request_of
from cosim.plot.style import WIDTHS, new_figure, styled
from cosim.reading import FORMS
from cosim.sweep.planning.plan import plan_of
from cosim.sweep.results.map_panel import MapPanel, Scale, panel_of
from cosim.sweep.sweep import SweepOutcome, run_sweep
from cosim.sweep.theory import is_stable
from tests.support.guide.blocks import ROOT, commands

IMAGES = ROOT / "docs" / "images"
PICTURE, NUMBERS = IMAGES / "stability_map.png", IMAGES / "stability_map.json"
BEGINS = "uv run cohaptic sweep single_axis_"
Cells = NDArray[np.bool_]


def lines() -> dict[str, list[str]]:
    """The arguments of the README's sweeps, by architecture."""
    shown = [each.line for each in commands() if each.page == "README.md"]
    found = [shlex.split(line)[4:] for line in shown if line.startswith(BEGINS)]
    return {each[0].removeprefix("single_axis_"): each for each in found}


def run(arguments: list[str], out: Path, workers: int) -> SweepOutcome:
    """What the command does with its arguments, before it writes and draws."""
    given = command.make_context("sweep", list(arguments)).params
    return run_sweep(plan_of(request_of(given), FORMS), out, workers=workers)


def judged(outcome: SweepOutcome) -> tuple[Cells, Cells]:
    """Where runs calm down, and where the theory says so: shape (stiffnesses, delays)."""
    assert all(result.is_over for result in outcome.results)
    panel = panel_of(outcome, *outcome.plan.axes)
    assert panel.radii is not None
    return panel.shares == 1.0, np.vectorize(is_stable)(panel.radii)


def wrong(good: Cells, stable: Cells) -> list[tuple[int, ...]]:
    """Cells in which the two differ, and which do not lie at the theory's boundary.

    Those that the boundary crosses may go either way, and their neighbours: a run is finite.
    """
    near = np.ones((3, 3), dtype=bool)
    crossed = binary_dilation(stable, near) & binary_dilation(~stable, near)
    return [tuple(map(int, cell)) for cell in np.argwhere((good != stable) & ~crossed)]


def kept(outcome: SweepOutcome) -> dict[str, Any]:
    """What is kept of a map."""
    panel = panel_of(outcome, *outcome.plan.axes)
    assert panel.radii is not None
    return {
        "across": [panel.across.label, panel.across.values.tolist()],
        "up": [panel.up.label, panel.up.values.tolist()],
        "good": ["".join(map(str, row)) for row in (panel.shares == 1.0).astype(int).tolist()],
        "radius": [[float(f"{radius:.6g}") for radius in row] for row in panel.radii.tolist()],
    }


def panel_from(numbers: dict[str, Any]) -> MapPanel:
    """A map from what was kept of it."""
    shares = np.array([[float(cell) for cell in row] for row in numbers["good"]])
    (across, values), (up, others) = numbers["across"], numbers["up"]
    return MapPanel(
        Scale(across, np.array(values)),
        Scale(up, np.array(others), is_log=True),
        shares,
        np.array(numbers["radius"]),
    )


def digest(content: bytes) -> str:
    """What the picture says that it was drawn from."""
    return hashlib.sha256(content).hexdigest()


def draw(numbers: Path, picture: Path) -> None:
    """Draw all maps side by side from what was kept."""
    content = numbers.read_bytes()
    with styled():
        figure = new_figure(WIDTHS["two"], 72.0)
        plots = figure.subplots(1, 2)
        for plot, (name, of_map) in zip(plots, json.loads(content).items(), strict=True):
            plot.set_title(name)
            mesh = panel_from(of_map).draw(plot)
        figure.colorbar(mesh, label="share of good runs")
        figure.savefig(picture, metadata={"Source": digest(content)})


def main() -> None:
    """Run both sweeps, keep what came out, and draw it."""
    found: dict[str, Any] = {}
    began, before = time.monotonic(), os.times()
    for name, arguments in lines().items():
        with tempfile.TemporaryDirectory() as folder:
            outcome = run(arguments, Path(folder) / "out", os.cpu_count() or 1)
        found[name] = kept(outcome)
        good, stable = judged(outcome)
        print(
            f"{name}: {good.size} runs, {good.sum()} calm down; the theory says otherwise in",
            end=" ",
        )
        print(f"{(good != stable).sum()}, {len(wrong(good, stable))} of them not at its boundary")
    used = sum(os.times()[:4]) - sum(before[:4])
    print(f"{time.monotonic() - began:.1f} s, {used:.1f} s of processor time")
    NUMBERS.write_text(json.dumps(found, indent=None, separators=(",", ":")) + "\n")
    draw(NUMBERS, PICTURE)


if __name__ == "__main__":
    main()
