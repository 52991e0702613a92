"""``cohaptic render``: the scene of a run as a gif, webp or mp4."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.complete import run_folders
from cosim.cli.support.values import Number, OutputFile, Quantity

FILMS = (".gif", ".webp", ".mp4")
MOST_FRAMES = 20_000


@click.command("render", cls=JsonCommand)
@click.argument("run", type=click.Path(path_type=Path), shell_complete=run_folders)
@click.option("--out", type=OutputFile(FILMS), required=True, help="A .gif, .webp or .mp4 file.")
@click.option(
    "--from", "start", type=Quantity("s"), default="0 s", help="Begin here.  [default: 0]"
)
@click.option("--until", type=Quantity("s"), help="End here.  [default: the run's end]")
@click.option(
    "--speed",
    type=Number(1e-3, 1e3),
    default=1.0,
    show_default=True,
    help="Simulated seconds a second.",
)
@click.option(
    "--frames",
    "rate",
    type=click.IntRange(1, 60),
    default=25,
    show_default=True,
    help="Pictures a second.",
)
@click.option(
    "--size",
    type=click.IntRange(120, 3840),
    nargs=2,
    default=(640, 480),
    show_default=True,
    metavar="WIDTH HEIGHT",
    help="Pixels.",
)
@click.option("--dark", is_flag=True, help="Light on dark.")
@click.option("--title", help="A line above the scene.  [default: the scenario's title]")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(
    *,
    run: Path,
    out: Path,
    start: Fraction,
    until: Fraction | None,
    speed: float,
    rate: int,
    size: tuple[int, int],
    dark: bool,
    title: str | None,
    as_json: bool,
) -> None:
    """Draw the scene of the RUN folder as a moving picture: box, fingers, forces, linkages."""
    from cosim.base.quantities.quantity import exact
    from cosim.record.reader import open_run
    from cosim.record.scene import read_scene
    from cosim.render.film import write_film
    from cosim.render.picture import Painter
    from cosim.render.poses import frame_ticks, read_poses

    if out.suffix.lower() == ".mp4" and any(side % 2 for side in size):
        raise InputError(f"--size {size[0]} {size[1]}: the sides of an mp4 are even numbers.")
    with open_run(run) as opened:
        scene = read_scene(opened.folder)
        if scene is None:
            raise InputError(
                f"{opened.folder}: there is no scene.json in it, so nothing can be drawn: the run "
                "is older than scenes are, or nothing in it moves. Run its scenario again."
            )
        start = max(start, opened.start_tick / opened.base_rate)
        last = (opened.start_tick + opened.ticks) / opened.base_rate
        end = last if until is None else min(until, last)
        if start >= end:
            raise InputError(f"from {float(start):g} s to {float(end):g} s there is nothing.")
        ticks = frame_ticks(opened, start, end, exact(speed) / rate)
        if len(ticks) > MOST_FRAMES:
            raise InputError(
                f"{len(ticks)} pictures are too many (at most {MOST_FRAMES}): raise --speed, or "
                "choose a part with --from and --until."
            )
        poses = read_poses(opened, scene, ticks)
        ran: Mapping[str, Any] = opened.manifest.get("scenario") or {}
    painter = Painter(
        scene,
        poses,
        size,
        scheme="dark" if dark else "light",
        title=str(ran.get("title") or "") if title is None else title,
    )

    def frames() -> Iterator[Any]:
        return (painter.frame(number) for number in range(len(poses)))

    write_film(frames, out, rate)
    if as_json:
        click.echo(json.dumps({"film": str(out), "frames": len(poses)}))
    else:
        click.echo(f"{out}: {len(poses)} pictures, {len(poses) / rate:.3g} s")
