"""``cohaptic theory map``: stability over a plane of two parameters."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import FIGURES, OutputFile
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.reading import read_range
from cosim.theory.stability.map import Axis, stability_maps


@click.command(cls=JsonCommand)
@click.option(
    "--vary", "names", multiple=True, metavar="NAME", help="Twice: to the right, then upward."
)
@click.option("--range", "spans", multiple=True, metavar="LOW:HIGH", help="Twice, in that order.")
@click.option("--points", type=click.IntRange(2, 2001), default=201, show_default=True)
@click.option("--out", type=OutputFile(FIGURES), help="A figure: .png, .svg or .pdf.")
@loop_options(chapter=5)
def command(
    *,
    loop: Loop,
    as_json: bool,
    names: tuple[str, ...],
    spans: tuple[str, ...],
    points: int,
    out: Path | None,
) -> None:
    """Which cells of a plane are stable: a figure with --out, rows of 0 and 1 with --json."""
    if len(names) != 2 or len(spans) != 2 or names[0] == names[1]:
        raise InputError(
            "Give two different parameters and their ranges: "
            "--vary k_11 --range 1:25000 --vary k_12 --range 1:4000."
        )
    axes: list[Axis] = []
    for name, span in zip(names, spans, strict=True):
        low, high = read_range(span)
        if not low < high:
            raise InputError(f"--range {span} is empty: give LOW:HIGH with LOW below HIGH.")
        axes.append(Axis(name, np.linspace(low, high, points)))
    delay = loop.timing.delay
    cells = stability_maps(loop.parameters, loop.timing, axes[0], axes[1], [delay])
    if out is not None:
        from cosim.report.theory_figures import draw_map

        draw_map(cells, (axes[0], axes[1]), [delay.total], describe(loop), out)
    share = float(cells.mean())
    result = {
        "stable_share": share,
        "vary": list(names),
        "horizontal": axes[0].values.tolist(),
        "vertical": axes[1].values.tolist(),
        "stable": cells[0].astype(int).tolist(),
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    where = f"\nwritten to {out}" if out is not None else ""
    text = f"{describe(loop)}\n{100 * share:.1f} % of the plane is stable{where}"
    emit(result, text, as_json=as_json, notes=loop.notes)
