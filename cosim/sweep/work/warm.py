"""One plan kept ready: its simulation, the rows in memory, and what is looked at in them."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from cosim.base.errors import CohapticError, InputError, RunError
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.base.recording import MemorySink, RecordGroup
from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.variation import with_values
from cosim.master.run.simulation import assemble
from cosim.master.run.whereabouts import Whereabouts
from cosim.record.memory import extremes_of, run_in_memory
from cosim.record.playback import KINDS
from cosim.record.reader import Run
from cosim.report.expectation import Expectation
from cosim.report.judged import Judged, judge
from cosim.report.measures import signals_of
from cosim.report.platform import find_platform
from cosim.report.target import Target, parse_target
from cosim.report.verdict.reading import parse_expectations
from cosim.report.window import MEASURES
from cosim.scenario import Kind, Scenario
from cosim.sweep.job import Job, RunResult, Task
from cosim.sweep.work.variants import build

_OTHER_ORDER = (
    "start: with these values components are computed in another order than in the scenario as it "
    "is written, so that runs cannot begin in the middle of it: let them begin at 0, or write one "
    "of these values into the scenario."
)


class Warm:
    """Runs scenarios of one plan, one after another."""

    def __init__(
        self, job: Job, scenario: Scenario, whereabouts: Whereabouts | None = None
    ) -> None:
        """Assemble a scenario and be ready to run it; ``whereabouts`` is told what it does.

        Where runs begin in the middle, what comes before is of the scenario as it is written: it
        must not depend on which point a worker happens to run first.

        Raises:
            InputError: it cannot be assembled, or it is none that can be repeated.
        """
        asked = scenario
        if job.start is not None:
            scenario = build(job.written, ())
        for name, part in scenario.components.items():
            if part.kind is Kind.DEVICE:
                raise InputError(f"{name} is a device; a sweep runs what is simulated.")
        self._job = job
        self._expected: dict[tuple[int, int], tuple[object, list[Expectation]]] = {}
        self._readings: list[tuple[str, Target, str]] = []
        self._simulation = assemble(
            scenario,
            kinds=KINDS,
            whereabouts=whereabouts,
            only=lambda groups: self._looked_at(scenario, groups),
        )
        self.whereabouts = self._simulation.whereabouts
        self._base = self._next = self._simulation.assembly
        self._sinks: dict[int, MemorySink] = {}
        self._runs: dict[int, Run] = {}
        self._last: MemorySink | None = None
        self._begun = self._is_stuck = False
        self._start = _tick_of(job.start, scenario)
        try:
            if job.start is not None and not self.turn_to(asked):
                raise InputError(_OTHER_ORDER)
        except CohapticError:
            self.close()
            raise

    @property
    def is_lost(self) -> bool:
        """Whether nothing more can be run here.

        An FMU met its end for good, or what comes before the points failed.
        """
        return self._is_stuck or any(fmu.is_lost for fmu in self._simulation.fmus.values())

    @property
    def assembly(self) -> Assembly:
        """What all the scenarios share."""
        return self._base

    def turn_to(self, scenario: Scenario) -> bool:
        """Whether the scenario has this plan; then it is the next to run."""
        assembly = with_values(self._base, scenario)
        if assembly is not None:
            self._next = assembly
        return assembly is not None

    def run(self, task: Task) -> RunResult:
        """Run what was turned to last.

        Raises:
            InputError: a component refuses its values, or an expectation cannot be.
            RunError: the run ended early.
        """
        assembly = self._next
        scenario = assembly.scenario
        expectations = self._expectations(scenario)
        sink = self._sink(scenario)
        if self._start is not None:
            self._branch(assembly, sink)
        elif self._begun:
            self._simulation.renew(assembly)
        self._begun = True
        self._last = sink
        try:
            outcome = self._simulation.run(sink, keep_fmus=True, briefly=True)
        finally:
            late = self._simulation.finish()
        if late:
            raise RunError(late)
        if outcome.interrupted:
            raise RunError("Interrupted.")
        judged = judge(self._run_of(sink, outcome.ticks), expectations, extremes_of(sink))
        measures, passed = self._found(judged)
        return RunResult(
            number=task.number,
            key=task.key,
            point=task.point,
            status="good" if judged.is_good else "failed",
            message="; ".join([*judged.failures, *map(str, judged.runaways[:1])]),
            measures=measures,
            passed=passed,
            ticks=outcome.ticks,
            seconds=outcome.wall_time,
        )

    def digest(self) -> str:
        """A digest (hex) of the rows of the last run."""
        state = hashlib.sha256()
        if self._last is not None:
            for number in range(len(self._last.groups)):
                state.update(self._last.rows(number).tobytes())
        return state.hexdigest()

    def close(self) -> None:
        """Free every FMU."""
        self._simulation.close()

    def _looked_at(self, scenario: Scenario, groups: Sequence[RecordGroup]) -> set[str]:
        """The signals that anybody asks for; everything else is not recorded."""
        columns = {column.name: column for group in groups for column in group.columns}
        self._groups = tuple(groups)
        found = signals_of(find_platform(columns))
        for expectation in parse_expectations(scenario, self._groups):
            found |= set(expectation.target.signals if expectation.target is not None else ())
        for text, name in self._job.readings:
            target = parse_target(text, columns)
            self._readings.append((f"{text} {name}", target, name))
            found |= set(target.signals)
        return found

    def _expectations(self, scenario: Scenario) -> list[Expectation]:
        """Parsed once for each set of them: most points have the base's."""
        key = (id(scenario.expect), scenario.ticks)
        kept = self._expected.get(key)
        if kept is None or kept[0] is not scenario.expect:
            kept = scenario.expect, parse_expectations(scenario, self._groups)
            self._expected[key] = kept
        return kept[1]

    def _sink(self, scenario: Scenario) -> MemorySink:
        sink = self._sinks.get(scenario.ticks)
        if sink is None:
            sink = self._sinks[scenario.ticks] = MemorySink(scenario.ticks)
        return sink

    def _run_of(self, sink: MemorySink, ticks: int) -> Run:
        """The rows as a run; where all are there, they lie where those of the run before did."""
        scenario = self._next.scenario
        whole, ending = scenario.ticks, {"exit": {"ticks": ticks}}
        if ticks < whole:
            return run_in_memory(sink, ending, scenario.start_tick)
        if whole not in self._runs:
            self._runs[whole] = run_in_memory(sink, ending, scenario.start_tick)
        return self._runs[whole]

    def _found(self, judged: Judged) -> tuple[dict[str, float], dict[str, bool]]:
        measures, passed = dict(judged.measures), dict[str, bool]()
        for verdict in judged.verdicts:
            name = verdict.expectation.name
            measures[f"{name} low"] = verdict.low
            measures[f"{name} high"] = verdict.high
            passed[name] = verdict.passed
        run = judged.inspection.run
        for label, target, name in self._readings:
            measures[label] = MEASURES[name](judged.inspection.window(target, 0, run.ticks))
        return measures, passed

    def _branch(self, assembly: Assembly, sink: MemorySink) -> None:
        """Be where points begin to differ; what comes before is run once."""
        assert self._start is not None
        base = self._sink(self._base.scenario)
        if not self._begun:
            self._is_stuck = True
            self._simulation.run(base, until=self._start, mark_at_end=True)
            self._is_stuck = False
        sink.keep(self._start, base)
        self._simulation.branch(assembly)


def _tick_of(text: str | None, scenario: Scenario) -> int | None:
    if text is None:
        return None
    try:
        tick = quantity(text, "s") * scenario.base_rate - scenario.start_tick
    except QuantityError as error:
        raise InputError(f"start: {error}") from None
    if tick.denominator != 1 or not 0 < tick < scenario.ticks:
        since = f" from {float(scenario.start_time):g} s on" if scenario.start_tick else ""
        raise InputError(
            f"start: {text} is no base tick within the run, which goes on for "
            f"{float(scenario.duration):g} s{since} at {float(scenario.base_rate):g} ticks "
            "a second."
        )
    return int(tick)
