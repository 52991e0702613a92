"""``run --snapshot`` and ``run --from``: states left in the run's folder, and runs from there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cosim.base.errors import InputError, RunError
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.base.recording import TextChanges
from cosim.master.assembly.clock import Clock
from cosim.master.run.checkpoint import refuse_unless_resumable
from cosim.master.run.execution.loop import Pause, Progress
from cosim.master.run.simulation import Simulation
from cosim.master.run.snapshot import Snapshot, read_snapshot
from cosim.record.reader import SCENARIO_FILE, Run, open_run
from cosim.record.texts.recorded import RecordedText

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from cosim.base.recording import RecordGroup, Rows
    from cosim.record.writer import Recorder
    from cosim.scenario import Scenario

Say = Callable[[str], None]
BLOCK_ROWS = 1024


def snapshot_file(folder: Path, tick: int) -> Path:
    """Where a run's folder has the state at a tick."""
    return folder / f"snapshot-{tick}"


def tick_at(time: str, scenario: Scenario, option: str) -> int:
    """A time that was given (``2.5s``, or seconds) as a tick, which counts from the start.

    Raises:
        InputError: it is no time, below 0, or between two ticks.
    """
    try:
        ticks = quantity(time, "s") * scenario.base_rate - scenario.start_tick
    except QuantityError as error:
        raise InputError(f"{option}: '{time}' is not a time: {error}") from None
    if ticks < 0:
        raise InputError(f"{option}: {time} lies before the run.")
    if ticks.denominator != 1:
        around = [int(ticks), int(ticks) + 1]
        clock = Clock(scenario.base_rate, scenario.start_tick)
        near = " and ".join(f"{clock.seconds(tick):.10g} s (tick {tick})" for tick in around)
        raise InputError(f"{option}: {time} lies between two ticks; the nearest are {near}.")
    return int(ticks)


@dataclass(frozen=True, slots=True)
class Origin:
    """An earlier run, and the time in it from which to go on."""

    folder: Path
    time: str

    @staticmethod
    def read(text: str) -> Origin:
        """From ``RUN@TIME``.

        Raises:
            InputError: it is not written so.
        """
        folder, at, time = text.rpartition("@")
        if not at or not folder or not time:
            raise InputError(
                f"--from takes a run's folder and a time, such as runs/box-1@2.5s, not '{text}'."
            )
        return Origin(Path(folder), time)


def scenario_to_run(
    scenario: str | None, origin: str | None, *, changed: bool, special: bool, realtime: bool
) -> str:
    """The scenario that was given, or the one that an earlier run has resolved.

    Raises:
        InputError: none or both were given, or what does not go together.
    """
    if (scenario is None) == (origin is None):
        raise InputError(
            "Name a scenario (a file, or a bundled one such as two_users_box), or a run to go on "
            "from with --from, and not both."
        )
    if special and realtime:
        raise InputError(
            "--snapshot and --from are for runs that do not keep pace; leave --realtime out."
        )
    if origin is None:
        return str(scenario)
    if changed:
        raise InputError(
            "--from goes on with the run's own scenario: leave --set and --with out; only "
            "--duration may differ."
        )
    file = Origin.read(origin).folder / SCENARIO_FILE
    if not file.is_file():
        raise InputError(f"--from: {file.parent} is no run's folder: it has no {SCENARIO_FILE}.")
    return str(file)


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
            simulation.run(recorder, progress=progress, pauses=pauses)
            return
        tick = tick_at(self.origin.time, simulation.scenario, "--from")
        with open_run(self.origin.folder) as run:
            snapshot = self._snapshot(run, tick)
            if snapshot is not None:
                simulation.restore(snapshot)
                if simulation.repeated:
                    self.say(_repeats(simulation))
            compared = Compared(recorder, run, 0 if snapshot is None else tick)
            simulation.run(compared, progress=progress, pauses=pauses)
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


class Compared:
    """A sink that begins with an earlier run's rows, and compares those that both runs have."""

    def __init__(self, recorder: Recorder, run: Run, first_tick: int) -> None:
        self._recorder, self._run, self._first = recorder, run, first_tick
        self._groups: Sequence[RecordGroup] = ()
        self._rows: dict[int, Rows] = {}
        self._last = 0
        self._different: tuple[int, str] | None = None
        self._texts: dict[tuple[int, int], TextChanges] = {}

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        """Begin the record with what there was before the first tick.

        Raises:
            InputError: the run recorded something else.
        """
        self._groups = groups
        if gone := set(self._run.groups) - {group.name for group in groups}:
            raise InputError(
                f"{self._run.folder} has the group {min(gone)} recorded, which this run has not."
            )
        for group in groups:
            there = self._run.groups.get(group.name)
            columns = {(each.name, each.unit or "", each.is_float) for each in group.columns}
            texts = {(each.name, each.is_binary) for each in group.texts}
            if (
                there is None
                or there.period != group.period
                or {(e.name, e.unit, e.is_float) for e in there.signals.values()} != columns
                or {(e.name, e.column.is_binary) for e in there.texts.values()} != texts
            ):
                raise InputError(
                    f"{self._run.folder} has something else recorded in the group {group.name}."
                )
        self._recorder.begin(groups, base_rate)
        for number, group in enumerate(groups):
            end = -(-self._first // group.period)
            for first in range(0, end, BLOCK_ROWS):
                last = min(first + BLOCK_ROWS, end)
                self._recorder.buffer(number, last - first)[:] = self._before(group, first, last)
                self._recorder.commit(number, first * group.period, last - first)
            for column, text in enumerate(group.texts):
                for tick, content in self._run.groups[group.name].texts[text.name].changes:
                    if tick < self._first:
                        self._recorder.put_text(number, column, tick, content)

    def buffer(self, group: int, rows: int) -> Rows:
        """The recorder's."""
        self._rows[group] = self._recorder.buffer(group, rows)
        return self._rows[group]

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """Compare what is new with what there was, and hand it over."""
        described = self._groups[group]
        first = first_tick // described.period
        last = min(first + rows, self._run.groups[described.name].rows)
        if first < last:
            self._compare(described, first, self._rows[group][: last - first])
            self._last = max(self._last, (last - 1) * described.period)
        self._recorder.commit(group, first_tick, rows)

    def put_text(self, group: int, column: int, tick: int, content: bytes) -> None:
        """Keep a change for ``judge``, and hand it over."""
        self._texts.setdefault((group, column), TextChanges()).add(tick, content)
        self._recorder.put_text(group, column, tick, content)

    def judge(self, clock: Clock) -> None:
        """Whether both runs had the same rows.

        Raises:
            RunError: names the first signal that had another value, and when.
        """
        self._compare_texts()
        if self._different is not None:
            tick, name = self._different
            raise RunError(
                f"This run is not {self._run.folder}: {name} has another value at tick {tick} "
                f"(t = {clock.seconds(tick):g} s). Something that the numbers depend on has "
                "changed since."
            )

    def sentence(self) -> str:
        """What was found to be the same."""
        if self._last < self._first:
            return (
                f"It goes on where {self._run.folder} ended, so that there is nothing to compare."
            )
        return f"Ticks {self._first} to {self._last} are those of {self._run.folder}, bit for bit."

    def _compare_texts(self) -> None:
        for (group, column), changes in self._texts.items():
            described = self._groups[group]
            name = described.texts[column].name
            there = self._run.groups[described.name].texts[name]
            now = RecordedText(there.column, tuple(changes.changes))
            ticks = {tick for text in (there, now) for tick, _ in text.changes}
            ticks |= {-(-self._first // described.period) * described.period}
            for tick in sorted(ticks):
                if self._first <= tick <= self._last and there.at(tick) != now.at(tick):
                    if self._different is None or tick < self._different[0]:
                        self._different = tick, name
                    break

    def _before(self, group: RecordGroup, first: int, last: int) -> NDArray[np.int64]:
        signals = self._run.groups[group.name].signals
        found = [signals[column.name].cells(first, last) for column in group.columns]
        return np.stack(found, axis=1)

    def _compare(self, group: RecordGroup, first: int, rows: Rows) -> None:
        differs = self._before(group, first, first + len(rows)) != rows
        if differs.any():
            row = int(differs.any(axis=1).argmax())
            tick = (first + row) * group.period
            if self._different is None or tick < self._different[0]:
                self._different = tick, group.columns[int(differs[row].argmax())].name


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
