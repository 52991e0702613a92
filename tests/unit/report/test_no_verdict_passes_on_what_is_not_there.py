"""Of every measure: what has no number, ran away, is too short or was not reached is not met.

The measures are taken from their tables, so a new one is judged here by itself. Limits are as wide
as they can be written: it is never the number that fails.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cosim.base.errors import InputError
from cosim.base.meaning import Meaning, Slot
from cosim.base.recording import Column, MemorySink, RecordGroup
from cosim.record.memory import extremes_of, run_in_memory
from cosim.record.reader import Run
from cosim.report.judged import judge
from cosim.report.measures import SCENARIO_MEASURES
from cosim.report.platform import POSE, find_platform
from cosim.report.summary import summarise
from cosim.report.target import Target
from cosim.report.verdict.evaluate import Verdict
from cosim.report.verdict.reading import parse_expectations
from cosim.report.window import MEASURES, measure
from tests.support.record.scenario_files import scenario
from tests.support.record.synthetic_run import RATE

ROWS = 2048
LATE = 1500
"""A row in the hold phase."""
Values = Mapping[str, NDArray[np.float64]]
ALL = [*SCENARIO_MEASURES, *(f"a.x {name}".strip() for name in ("", *MEASURES))]


OF_ALL = Slot()


def columns() -> dict[str, Column]:
    """Two copies of a box that two fingers hold, and a signal ``a.x``; all floating point."""

    def column(name: str, unit: str, meaning: Meaning | None = None, slot: Slot = OF_ALL) -> Column:
        return Column(name=name, unit=unit, is_float=True, meaning=meaning, belongs_to=slot)

    found = [column("a.x", "m")]
    for copy in "ab":
        found += [
            column(f"{copy}.{each.name.lower()}", unit, each)
            for each, unit in zip(POSE, ("m", "m", "rad"), strict=True)
        ]
        found += [
            column(f"{copy}.state", "1", Meaning.CONTACT_STATE, Slot(None, 1)),
            column(f"{copy}.force", "N", Meaning.NORMAL_FORCE, Slot(None, 1)),
            column(f"{copy}.depth", "m", Meaning.WALL_PENETRATION),
            column(f"{copy}.saturated", "1", Meaning.SATURATION, Slot(None, 1)),
        ]
    return {each.name: each for each in found}


COLUMNS = columns()


def sound() -> dict[str, NDArray[np.float64]]:
    """Values of which every measure is above 0."""
    row = np.arange(ROWS)
    wave = np.sin(2 * math.pi * row / 64)
    values: dict[str, NDArray[np.float64]] = {"a.x": row / ROWS * (2 + wave) / 4}
    values["a.x"][700] = 0.0
    for number, copy in enumerate("ab"):
        pose = (0.01 * row / ROWS, 0.02 * number * wave, 0.1 * number + 0 * wave)
        values |= {f"{copy}.{m.name.lower()}": each for m, each in zip(POSE, pose, strict=True)}
        values[f"{copy}.state"] = np.where((row > 9) & (row != 1200), 2.0, 0.0)
        values[f"{copy}.force"] = 1 + 0.1 * wave
        values[f"{copy}.depth"] = 0.001 * (1 + wave)
        values[f"{copy}.saturated"] = np.floor(row / 100)
    return values


def recorded(values: Values, rows: int = ROWS, period: int = 1, **ending: Any) -> tuple[Run, Any]:
    """A run of the first rows, as if it had ended so, and its extremes."""
    group = RecordGroup(
        name="control", period=period, columns=tuple(COLUMNS[name] for name in values)
    )
    cells = np.stack([each[:rows:period] for each in values.values()], axis=1)
    sink = MemorySink(ROWS)
    sink.begin((group,), RATE)
    sink.buffer(0, len(cells))[:] = np.ascontiguousarray(cells).view(np.int64)
    sink.commit(0, 0, len(cells))
    manifest = {
        "exit": {"status": 0, "ticks": rows, "message": "", **ending},
        "scenario": {"ticks": ROWS},
    }
    return run_in_memory(sink, manifest), extremes_of(sink)


def verdicts(folder: Path, what: str, run: tuple[Run, Any], window: str = "") -> list[Verdict]:
    """Of one measure, with limits far below and far above what the sound run has."""
    target, _, name = what.partition(" ")
    middle = MIDDLE[what]
    low, high = (middle / 2 if middle > 0 else middle - 1), middle + abs(middle) + 1
    if what in SCENARIO_MEASURES:
        high = min(high, SCENARIO_MEASURES[what].most)
    prefix = f"{name}_" if name else ""
    more = (", frequency: 100" if name == "amplitude" else "") + window
    limits = f"{prefix}above: {low!r}, {prefix}below: {high!r}{more}"
    loaded = scenario(folder, f"expect: {{{target}: {{{limits}}}}}")
    return judge(run[0], parse_expectations(loaded, run[0].record_groups), run[1]).verdicts


def _middles() -> dict[str, float]:
    run, extremes = recorded(sound())
    inspection = judge(run, (), extremes).inspection
    found = {name: inspection.value(name) for name in SCENARIO_MEASURES}
    window = measure(run, Target("a.x", ("a.x",)), 0, ROWS, 100.0)
    found |= {"a.x": 0.0} | {f"a.x {name}": of(window) for name, of in MEASURES.items()}
    assert all(value is not None and math.isfinite(value) for value in found.values())
    return {name: float(value or 0.0) for name, value in found.items()}


MIDDLE = _middles()


def reads(what: str) -> list[str]:
    if what in SCENARIO_MEASURES:
        return list(SCENARIO_MEASURES[what].reads(find_platform(COLUMNS)))
    return ["a.x"]


@pytest.mark.parametrize("what", ALL)
def test_it_is_met_by_the_sound_run(what: str, tmp_path: Path) -> None:
    """Or nothing below would say anything; a slower record of the same tells the same."""
    assert all(each.passed for each in verdicts(tmp_path, what, recorded(sound())))
    assert all(each.passed for each in verdicts(tmp_path, what, recorded(sound()), ", to: 2"))
    if what != "contact_losses" and "_count" not in what:  # 1 row each is lost by that
        assert all(each.passed for each in verdicts(tmp_path, what, recorded(sound(), period=4)))


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("what", ALL)
def test_one_row_without_a_finite_number_fails_it(what: str, wrong: float, tmp_path: Path) -> None:
    assert reads(what)
    for name in reads(what):
        values = sound()
        values[name][LATE] = wrong
        for verdict in verdicts(tmp_path, what, recorded(values)):
            assert not verdict.passed, (name, str(verdict))
            assert f"{name} is {wrong} at t = {LATE / 1024:g} s" in str(verdict)
        for verdict in verdicts(tmp_path, what, recorded(values), ", from: 1, to: 1.9"):
            assert not verdict.passed, (name, str(verdict))


@pytest.mark.parametrize("what", ALL)
def test_what_ran_away_fails_it(what: str, tmp_path: Path) -> None:
    """Once is enough, also before its window; but it may be of divergence itself."""
    for name in reads(what):
        values = sound()
        values[name][LATE] = 1e13
        for window in ("", ", from: 1.8"):
            for verdict in verdicts(tmp_path, what, recorded(values), window):
                if verdict.expectation.is_of_divergence:
                    assert what == "a.x growth"
                    continue
                assert not verdict.passed, (name, str(verdict))
                assert f"{name} ran away" in str(verdict) or not verdict.lacking


def test_a_run_that_diverged_anywhere_fails_what_is_said_of_all_of_it(tmp_path: Path) -> None:
    values = sound()
    values["a.x"][LATE] = 1e3
    for what in SCENARIO_MEASURES:
        for verdict in verdicts(tmp_path, what, recorded(values)):
            assert "a.x ran away" in str(verdict)
            assert not verdict.passed


@pytest.mark.parametrize("what", ALL)
def test_a_window_that_the_run_did_not_reach_fails_it(what: str, tmp_path: Path) -> None:
    for ending in ({"status": 0}, {"status": 1}):
        run = recorded(sound(), rows=1400, **ending)
        for window in (", from: 1.5", ", to: 1.9", ", from: 1, to: 2"):
            for verdict in verdicts(tmp_path, what, run, window):
                assert not verdict.passed, str(verdict)
                assert verdict.lacking


@pytest.mark.parametrize("what", ALL)
def test_a_run_that_was_cut_short_fails_what_is_said_of_all_of_it(
    what: str, tmp_path: Path
) -> None:
    """Which a run that a model ended is not: it is judged as it is."""
    for window in ("", ", from: 0.1"):
        for verdict in verdicts(tmp_path, what, recorded(sound(), rows=1800, status=1), window):
            assert not verdict.passed, str(verdict)
            assert "the run ended at 1.75781 s" in str(verdict)
        assert all(
            each.passed for each in verdicts(tmp_path, what, recorded(sound(), rows=1800), window)
        )
    run, extremes = recorded(sound(), rows=1800)
    run.manifest = {**run.manifest, "exit": None}  # nobody was left to say how it ended
    assert not any(each.passed for each in verdicts(tmp_path, what, (run, extremes)))


@pytest.mark.parametrize("what", ALL)
def test_one_sample_tells_only_what_one_sample_can(what: str, tmp_path: Path) -> None:
    name = what.removeprefix("a.x").strip()
    needed = SCENARIO_MEASURES[what] if what in SCENARIO_MEASURES else MEASURES.get(name)
    if needed is None or needed.samples == 1:
        verdicts(tmp_path, what, recorded(sound()), ", from: 1.5, to: 1.5")
        return
    with pytest.raises(InputError, match=r"small\.yaml:8:\d+: this window holds one sample of"):
        verdicts(tmp_path, what, recorded(sound()), ", from: 1.5, to: 1.5")


@pytest.mark.parametrize("what", ALL)
def test_a_window_between_samples_is_refused(what: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"small\.yaml:8:\d+: this window holds no sample of"):
        verdicts(tmp_path, what, recorded(sound(), period=64), ", from: 1.01, to: 1.05")


@pytest.mark.parametrize("what", ALL)
def test_what_is_not_recorded_is_refused(what: str, tmp_path: Path) -> None:
    left = {name: each for name, each in sound().items() if name not in reads(what)}
    with pytest.raises(InputError, match=r"small\.yaml:8:\d+: .*recorded"):
        verdicts(tmp_path, what, recorded(left or {"b.depth": sound()["b.depth"]}))


@pytest.mark.parametrize("what", ["grip_force", "force_ripple"])
def test_the_weakest_contact_is_not_told_without_that_of_each(what: str, tmp_path: Path) -> None:
    values = sound()
    del values["b.force"]
    assert not any(each.passed for each in verdicts(tmp_path, what, recorded(values)))


def test_no_measure_reads_more_than_it_says() -> None:
    """A measure that read another signal would not be asked whether that has numbers."""
    for name in SCENARIO_MEASURES:
        for other in set(COLUMNS) - {"a.x"} - set(reads(name)):
            values = sound()
            values[other] = values[other] * 1.5 + 0.125
            run, extremes = recorded(values)
            value = judge(run, (), extremes).inspection.value(name)
            assert value == MIDDLE[name], (name, other)


def test_the_summary_of_a_run_judges_as_the_sweep_does(tmp_path: Path) -> None:
    """Both know extremes of whole signals; neither may forget a row without a number."""
    values = sound()
    values["b.depth"][LATE] = math.nan
    run, extremes = recorded(values)
    loaded = scenario(tmp_path, "expect: {wall_penetration: {below: 50, above: 1e-6}}")
    expectations = parse_expectations(loaded, run.record_groups)
    summary = summarise(run, expectations).content
    assert [each["passed"] for each in summary["expectations"]] == [False, False]
    assert summary["measures"] == judge(run, expectations, extremes).measures
    assert "wall_penetration" not in summary["measures"]
