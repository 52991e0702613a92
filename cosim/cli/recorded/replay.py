"""``cohaptic replay``: compute a run again and tell whether it is the same, bit for bit."""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.complete import run_folders
from cosim.cli.support.values import OutputFolder

if TYPE_CHECKING:
    from cosim.master.run.execution.loop import Progress
    from cosim.master.run.simulation import Simulation
    from cosim.record.writer import Recorder
    from cosim.scenario import Scenario


@click.command("replay", cls=JsonCommand)
@click.argument("run", type=click.Path(path_type=Path), shell_complete=run_folders)
@click.option("--out", type=OutputFolder(), help="Keep the new run here. [default: it is not kept]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(run: Path, *, out: Path | None, as_json: bool) -> None:
    """Compute RUN again from its resolved scenario, and compare every value that it recorded.

    Devices are played back from the record: what they measured is taken from there, and what the
    models made of it is compared. Exit status: 0 all is the same, 1 something is not (the first
    tick and signal are told), 2 the run cannot be computed again.
    """
    from cosim.cli.support.check_devices import DeviceJudge
    from cosim.cli.support.devices import say
    from cosim.cli.support.run.child import run_in_child
    from cosim.reading import load
    from cosim.record.reader import open_run

    with open_run(run) as opened:
        ticks = opened.ticks
        written, folder = opened.scenario_file, opened.folder
    if ticks == 0:
        raise InputError(f"{run} holds no tick that could be compared.")
    scenario = with_playback(load(written), folder)
    with tempfile.TemporaryDirectory(prefix="cohaptic-") as scratch:
        finished = run_in_child(
            scenario,
            out or Path(scratch) / "run",
            progress=None,
            execute=Replay(folder, ticks),
            figure=out is not None,
            page=out is not None,
            judge=DeviceJudge(realtime=False),
            say=say,
        )
    message = str(finished.error) if finished.error is not None else ""
    if not message and finished.summary.content["ticks"] < ticks:
        message = finished.summary.content["message"] or "The new run ended early."
    if as_json:
        import json

        click.echo(json.dumps({"equal": not message, "ticks": ticks, "message": message}))
    else:
        click.echo(message or f"{run}: all {ticks} ticks are the same, bit for bit.")
    sys.exit(int(bool(message)))


def with_playback(scenario: Scenario, folder: Path) -> Scenario:
    """The scenario with every device in it played back from a run's folder."""
    from cosim.master.components.python_component import open_device
    from cosim.scenario import Kind

    components = dict(scenario.components)
    for name, part in scenario.components.items():
        if part.kind is Kind.DEVICE:
            device = open_device(part.source, part.options, scenario.safety)
            components[name] = replace(
                part,
                kind=Kind.PLAYBACK,
                source=str(folder.absolute()),
                options={"component": name, "terminals": device.terminals},
                parameters={},
                start={},
            )
    return replace(scenario, components=components, safety={})


class Replay:
    """Runs a simulation as far as an earlier run came, and compares."""

    def __init__(self, folder: Path, ticks: int) -> None:
        self._folder, self._ticks = folder, ticks

    def __call__(
        self, simulation: Simulation, recorder: Recorder, progress: Progress | None
    ) -> None:
        """Run.

        Raises:
            RunError: the run failed, or has other values than the earlier one.
        """
        from cosim.continuation.compared import Compared
        from cosim.record.reader import open_run

        with open_run(self._folder) as run:
            compared = Compared(recorder, run, 0)
            simulation.run(compared, progress=progress, until=self._ticks, keep_fmus=True)
            compared.judge(simulation.assembly.clock)
