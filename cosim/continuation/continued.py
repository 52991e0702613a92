"""A run from an earlier one's state, that leaves states behind for others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cosim.base.errors import InputError
from cosim.continuation.compared import Compared
from cosim.continuation.origin import Origin, tick_at
from cosim.master.run.checkpoint import refuse_unless_resumable
from cosim.master.run.execution.loop import Pause, Progress
from cosim.master.run.simulation import Simulation
from cosim.master.run.snapshot import Snapshot, read_snapshot
from cosim.record.reader import Run, open_run

if TYPE_CHECKING:
    from cosim.record.writer import Recorder

Say = Callable[[str], None]


def snapshot_file(folder: Path, tick: int) -> Path:
    """Where a run's folder has the state at a tick."""
    return folder / f"snapshot-{tick}"


def continuation(say: Say, origin: str | None, keep: Sequence[str]) -> Continuation | None:
    """What runs the simulation, where either option was given."""
    if origin is None and not keep:
        return None
    return Continuation(say, None if origin is None else Origin.read(origin), tuple(keep))


@dataclass(frozen=True, slots=True)
class Continuation:
    """Runs a simulation here, from an earlier run's state, and leaves states behind."""

    say: Say
    origin: Origin | None = None
    keep: Sequence[str] = ()
    """Times at which a snapshot is left in the run's folder."""

    def __call__(
        self, simulation: Simulation, recorder: Recorder, progress: Progress | None
    ) -> None:
        """Run to the end.

        Raises:
            InputError: a time, the run or its snapshot cannot be used.
            RunError: the run failed, or is not the one that it goes on from.
        """
        refuse_unless_resumable(simulation.assembly)
        pauses = self._pauses(simulation, recorder)
        if self.origin is None:
            simulation.run(recorder, progress=progress, pauses=pauses, keep_fmus=True)
            return
        tick = tick_at(self.origin.time, simulation.scenario, "--from")
        with open_run(self.origin.folder) as run:
            snapshot = self._snapshot(run, tick)
            if snapshot is not None:
                simulation.restore(snapshot)
                if simulation.repeated:
                    self.say(_repeats(simulation))
            compared = Compared(recorder, run, 0 if snapshot is None else tick)
            simulation.run(compared, progress=progress, pauses=pauses, keep_fmus=True)
            compared.judge(simulation.assembly.clock)
            self.say(compared.sentence())

    def _snapshot(self, run: Run, tick: int) -> Snapshot | None:
        if tick > run.ticks:
            raise InputError(
                f"--from: {run.folder} was recorded up to tick {run.ticks}, not to tick {tick}."
            )
        file = snapshot_file(run.folder, tick)
        if file.is_file():
            found = read_snapshot(file)
            if found.tick != tick:
                raise InputError(f"{file} is of tick {found.tick}; it has another file's name.")
            return found
        self.say(
            f"{run.folder} has no snapshot of tick {tick} (cohaptic run --snapshot leaves one), so "
            "that it is computed again from tick 0 and compared."
        )
        return None

    def _pauses(self, simulation: Simulation, recorder: Recorder) -> dict[int, Pause]:
        end, clock = simulation.scenario.ticks, simulation.assembly.clock
        ticks = [tick_at(time, simulation.scenario, "--snapshot") for time in self.keep]
        for time, tick in zip(self.keep, ticks, strict=True):
            if tick > end:
                raise InputError(
                    f"--snapshot: {time} lies behind the run's end, {clock.seconds(end):g} s."
                )
        if ticks and simulation.repeated:
            self.say(_repeats(simulation))
        return {tick: lambda tick=tick: _leave(simulation, recorder, tick) for tick in ticks}


def _leave(simulation: Simulation, recorder: Recorder, tick: int) -> None:
    try:
        simulation.snapshot().write(snapshot_file(recorder.path.parent, tick))
    except OSError as error:
        raise recorder.refusal(error) from error


def _repeats(simulation: Simulation) -> str:
    names = ", ".join(simulation.repeated)
    return (
        f"The FMU of {names} does not give its state away: a run from a snapshot computes "
        "everything again from tick 0 and checks that it comes to the same values."
    )
