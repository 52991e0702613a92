"""One run from a scenario to a folder: assembled, run, recorded, summarised, drawn.

The commands, sweeps and tests all run scenarios through here.
"""

from __future__ import annotations

import html
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from cosim.base.component import Component
from cosim.base.errors import CohapticError, RunError
from cosim.master.run.execution.loop import Progress
from cosim.master.run.obituary import COMPLETE
from cosim.master.run.outcome import Outcome
from cosim.master.run.simulation import Simulation
from cosim.master.run.whereabouts import Whereabouts
from cosim.preparation.prepare import Judge, prepare
from cosim.record.folder import check_folder
from cosim.record.manifest import conclude, describe, replace_file, write_json, write_manifest
from cosim.record.reader import Run, open_run
from cosim.record.writer import Recorder
from cosim.report.drawings import Drawings
from cosim.report.expectation import Expectation
from cosim.report.summary import SUMMARY_FILE, Summary, summarise
from cosim.scenario import Scenario
from cosim.scene import describe_scene

if TYPE_CHECKING:
    from cosim.theory.stability.told import ToldLoop
from cosim.preparation.provenance import components_of_run, input_files
from cosim.preparation.run_folder import FolderRecorder

LOG_FILE = "fmu.log"


_SHOWN = 8
"""Measures that a notebook shows of a run."""


Execute = Callable[[Simulation, Recorder, Progress | None], None]
"""Runs a simulation to its end into a recorder."""


@dataclass(frozen=True, slots=True, repr=False)
class Finished:
    """A run that is over: its folder, its summary, and the error that ended it, if one did."""

    folder: Path
    summary: Summary
    error: CohapticError | None

    def open(self) -> Run:
        """Its record, for reading; a context manager."""
        return open_run(self.folder)

    def __repr__(self) -> str:
        content = self.summary.content
        verdict = content["message"] or "it ran to its end"
        lines = [f"Run {self.folder}: {verdict}"]
        lines.append(f"  {content['simulated_time']:g} s in {content['wall_time']:.3g} s")
        measures = list(content["measures"].items())
        lines += [f"  {name} = {value:.4g}" for name, value in measures[:_SHOWN]]
        if len(measures) > _SHOWN:
            lines.append(f"  and {len(measures) - _SHOWN} more in .summary")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}</pre>"


class RunWatcher(Protocol):
    """Follows a run from outside of its process."""

    @property
    def whereabouts(self) -> Whereabouts:
        """Where the run says what it does."""
        ...

    def begun(self, folder: Path) -> None:
        """There is a record, in this folder."""
        ...

    def finished(self, finished: Finished) -> None:
        """All is written; the FMUs are not freed yet."""
        ...


def run_scenario(
    scenario: Scenario,
    out: Path | None = None,
    *,
    progress: Progress | None = None,
    execute: Execute | None = None,
    deadlines: Callable[[], Mapping[str, Any]] | None = None,
    figure: bool = True,
    page: bool | None = None,
    instances: Mapping[str, Component] | None = None,
    judge: Judge | None = None,
    say: Callable[[str], None] | None = None,
    link: Callable[[], Mapping[str, Any]] | None = None,
    watcher: RunWatcher | None = None,
) -> Finished:
    """Run a scenario into ``out``, or into the next free ``runs/<scenario>-<n>``.

    Ctrl-C and an error in the loop end the run early; what was reached is recorded, summarised and
    drawn all the same. ``execute`` runs the simulation elsewhere (in a process of its own) in place
    of ``simulation.run``. ``figure`` has ``overview.png`` drawn and ``page`` ``report.html`` made,
    the page as the figure where nothing is said. ``deadlines`` is asked for its statistics after a
    paced run, ``link`` for those of a real link. ``instances`` holds components that exist already,
    by name.
    ``judge`` looks at devices before anything begins; ``say`` hears what is probably not meant.
    ``watcher`` is told how far the run is.

    Everything happens in this process: an FMU that calls ``exit`` ends it, with a sentence and
    status 1, and one that crashes without a word; the commands run simulations in a child
    (``cosim.cli.support.run.child``).

    Raises:
        InputError: the scenario, an FMU, an expectation or ``out`` cannot be used; no folder is
            left behind.
        RunError: the record could not be begun, so that there is nothing to summarise.
    """
    began = time.perf_counter()
    check_folder(out)
    whereabouts = None if watcher is None else watcher.whereabouts
    prepared = prepare(scenario, out, instances=instances, judge=judge, whereabouts=whereabouts)
    if say is not None:
        for warning in prepared.warnings:
            say(f"warning: {warning}")
    expectations = prepared.expectations
    manifest: dict[str, Any] = {}
    finished: Finished | None = None
    said: Mapping[str, Sequence[object]] = {}
    try:
        with prepared.simulation as simulation:
            manifest |= describe(simulation.scenario, components_of_run(simulation))
            manifest["files"] = input_files(simulation)
            manifest["notes"] = [*simulation.notes, *prepared.warnings]
            tell = None if watcher is None else watcher.begun
            recorder = FolderRecorder(simulation.scenario, out, manifest, began, tell)
            error = _run(simulation, recorder, execute or _here, progress)
            recorder.keep_scenario(simulation.replay())
            folder, outcome = recorder.folder, simulation.outcome
            said = outcome.said
            if folder is None or not recorder.has_begun:
                raise error or RunError("Interrupted before the first tick; nothing was recorded.")
            manifest["timing"] = _timing(outcome, recorder, scenario)
            manifest["channels"] = {
                name: asdict(counts) for name, counts in outcome.channels.items()
            }
            manifest["warnings"] = dict(outcome.warnings)
            manifest["deadlines"] = None if deadlines is None else dict(deadlines())
            manifest["link"] = None if link is None else dict(link())
            conclude(
                manifest,
                status=_status(outcome, error),
                message=_message(outcome, error, scenario),
                ticks=outcome.ticks,
            )
            leave = _Leaver()
            leave(lambda: write_manifest(folder, manifest))
            if outcome.said:
                leave(lambda: write_log(folder / LOG_FILE, outcome.said))
            scene = describe_scene(simulation.assembly, simulation.groups)
            drawings = Drawings(
                figure,
                figure if page is None else page,
                scene,
                lambda: _theory_of(simulation.scenario),
            )
            content = _report(folder, manifest, recorder, expectations, drawings, leave=leave)
            # Last, so that it is the peak of everything, the figure included.
            content["peak_memory"] = peak_memory()
            leave(lambda: write_json(folder / SUMMARY_FILE, content))
            if leave.error is not None and not content["message"]:
                content |= {"status": 1, "message": str(recorder.refusal(leave.error))}
            finished = Finished(folder, Summary(content), error)
            if watcher is not None:
                watcher.finished(finished)
        # FMUs are freed here: the record is finished should one of them die of it.
    except RunError as late:
        if finished is None:
            raise
        if finished.error is None:
            finished = _failed_late(finished, manifest, f"{late}; {COMPLETE}.")
            if watcher is not None:
                watcher.finished(finished)
    last_words = prepared.simulation.outcome.said  # while they were terminated and freed
    if last_words != said:
        with suppress(OSError):
            write_log(finished.folder / LOG_FILE, last_words)
    return finished


def _failed_late(finished: Finished, manifest: dict[str, Any], message: str) -> Finished:
    """A run that was recorded, and of which an FMU failed when it was closed."""
    manifest["exit"] |= {"status": 1, "message": message}
    content = {**finished.summary.content, "status": 1, "message": message}
    with suppress(OSError):
        write_manifest(finished.folder, manifest)
        write_json(finished.folder / SUMMARY_FILE, content)
    return Finished(finished.folder, Summary(content), RunError(message))


def _here(simulation: Simulation, recorder: Recorder, progress: Progress | None) -> None:
    """Run in this very thread."""
    simulation.run(recorder, progress=progress, keep_fmus=True)


def _run(
    simulation: Simulation, recorder: Recorder, execute: Execute, progress: Progress | None
) -> CohapticError | None:
    """The loop; the record is complete afterwards, whatever happened."""
    try:
        with recorder:
            execute(simulation, recorder, progress)
    except CohapticError as error:
        return error
    return None


def _theory_of(scenario: Scenario) -> tuple[ToldLoop, ...]:
    """What the theory says, imported when a page asks for it: the run is over by then."""
    from cosim.analysis.worlds import tell_of

    return tell_of(scenario)


class _Leaver:
    """Leaves files behind, and keeps the first refusal: the record matters more than they do."""

    def __init__(self) -> None:
        self.error: OSError | None = None

    def __call__(self, write: Callable[[], None]) -> None:
        try:
            write()
        except OSError as error:
            self.error = self.error or error


def _report(
    folder: Path,
    manifest: Mapping[str, Any],
    recorder: Recorder,
    expectations: Sequence[Expectation],
    drawings: Drawings,
    *,
    leave: _Leaver,
) -> dict[str, Any]:
    """The summary's content; what is drawn is written through ``leave``."""
    summaries = recorder.summaries()
    with open_run(folder) as run:
        run.manifest = manifest
        content = dict(summarise(run, expectations, summaries).content)
        for name, write in drawings.files(run, content, summaries).items():
            leave(lambda name=name, write=write: replace_file(folder / name, write))
    return content


def _timing(outcome: Outcome, recorder: FolderRecorder, scenario: Scenario) -> dict[str, float]:
    """The loop's wall time with everything recorded, start-up and figure apart."""
    wall_time = outcome.wall_time + recorder.drain_time
    simulated = float(outcome.ticks / scenario.base_rate)
    return {
        "wall_time": wall_time,
        "real_time_factor": simulated / wall_time if wall_time else 0.0,
        "start_up_time": recorder.start_up_time,
    }


def peak_memory() -> int:
    """Most memory that this process ever held (bytes)."""
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
        return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) * 1024
    except (OSError, StopIteration):
        pass
    try:
        import resource
    except ImportError:  # Windows
        return 0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _status(outcome: Outcome, error: CohapticError | None) -> int:
    if error is not None:
        return error.exit_status
    return int(outcome.interrupted)


def _message(outcome: Outcome, error: CohapticError | None, scenario: Scenario) -> str:
    if error is not None:
        return str(error)
    if outcome.interrupted:
        reached = float((scenario.start_tick + outcome.ticks) / scenario.base_rate)
        return (
            f"Interrupted at tick {outcome.ticks} of {scenario.ticks} (t = {reached:g} s); "
            "the record holds everything before."
        )
    return f"{outcome.ended_by}, where the run ended." if outcome.ended_by else ""


def write_log(path: Path, said: Mapping[str, Sequence[object]]) -> None:
    """What FMUs logged as a warning or worse, each text once with its count."""
    lines = [f"{name}: {each}\n" for name, texts in said.items() for each in texts]
    path.write_text("".join(lines), encoding="utf-8")
