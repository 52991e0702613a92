"""``expect:`` says what plain NumPy says of the same columns; what cannot be meant is refused."""

from __future__ import annotations

import tempfile
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.base.meaning import Meaning, Slot
from cosim.base.recording import Column, RecordGroup
from cosim.record import open_run
from cosim.report.expectation import COMPARISONS
from cosim.report.measures import Inspection
from cosim.report.platform import POSE
from cosim.report.target import Target
from cosim.report.verdict.evaluate import Verdict, evaluate
from cosim.report.verdict.reading import parse_expectations
from cosim.report.window import MEASURES, measure
from tests.support.record.scenario_files import scenario
from tests.support.record.synthetic_run import write

RATE = 1024


def verdicts(folder: Path, *lines: str) -> list[Verdict]:
    loaded = scenario(folder, "expect:", *lines)
    with open_run(folder) as run:
        return evaluate(Inspection(run), parse_expectations(loaded, run.record_groups))


def record(
    folder: Path, values: np.ndarray, *, slow: np.ndarray | None = None, start_tick: int = 0
) -> None:
    """Column ``a.x`` (m) at 1024 Hz and ``a.slow`` (m) at 128 Hz."""
    fast = RecordGroup(
        name="control", period=1, columns=(Column(name="a.x", unit="m", is_float=True),)
    )
    held = RecordGroup(
        name="network", period=8, columns=(Column(name="a.slow", unit="m", is_float=True),)
    )
    slow = np.zeros(-(-len(values) // 8)) if slow is None else slow
    cells = (values.astype(float).view(np.int64)[:, None], slow.view(np.int64)[:, None])
    write(folder / "run.h5", (fast, held), cells, start_tick=start_tick)


PLAIN = {
    "min": np.min,
    "max": np.max,
    "max_abs": lambda x: np.abs(x).max(),
    "peak_to_peak": np.ptp,
    "mean": np.mean,
    "rms": lambda x: np.sqrt(np.mean(x**2)),
    "std": np.std,
    "initial": lambda x: x[0],
    "final": lambda x: x[-1],
    "change": lambda x: x[-1] - x[0],
    "change_count": lambda x: np.count_nonzero(x[1:] != x[:-1]),
    "loss_count": lambda x: sum(1 for a, b in pairwise(x) if a and not b),
}


@settings(deadline=None, max_examples=30)
@given(st.data())
def test_every_measure_and_comparison_is_numpys(data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(PLAIN)))
    random = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    is_count = name.endswith("_count")
    values = random.choice([0.0, 1.0, -2.5], 2048) if is_count else random.normal(size=2048)
    start = data.draw(st.integers(0, 2046))
    stop = data.draw(st.integers(start + 1, 2047))
    expected = float(PLAIN[name](values[start : stop + 1]))
    threshold = data.draw(st.sampled_from([expected - 0.5, expected, expected + 0.5]))
    with tempfile.TemporaryDirectory() as folder:
        record(Path(folder), values)
        window = f"from: {start / RATE!r}, to: {stop / RATE!r}"
        below, within = verdicts(
            Path(folder),
            f"  a.x: {{{name}_below: {threshold!r}, {name}_within: [{threshold - 1!r}, "
            f"{threshold + 1!r}], {window}}}",
        )
    assert below.low == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert within.passed
    if abs(threshold - expected) > 0.1:
        assert below.passed == (expected < threshold)


def test_every_measure_has_a_plain_twin_here() -> None:
    assert set(PLAIN) == set(MEASURES) - {"amplitude", "growth"}


@pytest.mark.parametrize(
    ("comparison", "passing", "failing"),
    [
        ("below", "1.001", "1"),
        ("above", "-1.001", "-1"),
        ("within", "[-1, 1]", "[-1, 0.99]"),
        ("equals", "1", "0.5"),
    ],
)
def test_a_comparison_alone_speaks_of_every_value(
    comparison: str, passing: str, failing: str, tmp_path: Path
) -> None:
    values = np.ones(2048) if comparison == "equals" else np.linspace(-1, 1, 2048)
    record(tmp_path, values)
    assert set(COMPARISONS) == {"below", "above", "within", "equals"}
    for threshold, expected in ((passing, True), (failing, False)):
        (verdict,) = verdicts(tmp_path, f"  a.x: {{{comparison}: {threshold}}}")
        assert verdict.passed is expected


def test_the_amplitude_is_that_of_the_sine_in_the_signal(tmp_path: Path) -> None:
    time = np.arange(2048) / RATE
    record(tmp_path, 0.3 + 0.05 * np.sin(20 * time + 1.0) + 0.01 * np.sin(170 * time))
    (verdict,) = verdicts(tmp_path, "  a.x: {amplitude_within: [0.049, 0.051], frequency: 20}")
    assert verdict.passed
    assert verdict.low == pytest.approx(0.05, rel=0.02)


def test_a_slower_signal_is_held_not_interpolated(tmp_path: Path) -> None:
    slow = np.arange(256.0)
    record(tmp_path, np.repeat(slow, 8), slow=slow)
    (verdict,) = verdicts(tmp_path, "  a.x - a.slow: {equals: 0}")
    assert verdict.passed


def test_the_length_of_a_difference_of_vectors(tmp_path: Path) -> None:
    random = np.random.default_rng(5).normal(size=(2048, 4))
    columns = tuple(
        Column(name=name, unit="m", is_float=True)
        for name in ("a.p[1]", "a.p[2]", "b.p[1]", "b.p[2]")
    )
    group = RecordGroup(name="control", period=1, columns=columns)
    write(tmp_path / "run.h5", (group,), (random.view(np.int64),))
    (verdict,) = verdicts(tmp_path, "  '|a.p - b.p|': {max_below: 100}")
    assert verdict.low == np.sqrt(((random[:, :2] - random[:, 2:]) ** 2).sum(axis=1)).max()


def test_windows_have_names_and_thresholds_have_units(tmp_path: Path) -> None:
    record(tmp_path, np.linspace(0, 0.002, 2048))
    found = verdicts(
        tmp_path,
        "  a.x:",
        "    early: {to: 500 ms, max_below: 0.51 mm}",
        "    late: {from: 1.5, min_above: 1.4 mm}",
    )
    assert [(verdict.expectation.label, verdict.passed) for verdict in found] == [
        ("early", True),
        ("late", True),
    ]


def test_what_was_not_measured_is_not_as_expected(tmp_path: Path) -> None:
    """A NaN, or a window that the run never reached, passes nothing."""
    record(tmp_path, np.where(np.arange(1024) == 5, np.nan, 0.0))
    for window in ("to: 1", "from: 1.5"):
        for predicate in ("max_below: 1", "min_above: -1", "mean_within: [-1, 1]", "equals: 0"):
            (verdict,) = verdicts(tmp_path, f"  a.x: {{{predicate}, {window}}}")
            assert not verdict.passed
            reason = "no finite number: a.x is nan at t = 0.0048" if "to" in window else "nothing"
            assert reason in str(verdict)


@pytest.mark.parametrize("window", ["", ", from: 0", ", from: 0, to: 2"])
def test_what_grows_grows_whatever_window_is_written(window: str, tmp_path: Path) -> None:
    """The halves are those of the rows that there are: one without any would have no width."""
    time = np.arange(2048) / RATE
    record(tmp_path, np.exp(time) * np.sin(300 * time))
    (verdict,) = verdicts(tmp_path, f"  a.x: {{growth_within: [0.9, 1.1]{window}}}")
    assert verdict.passed, str(verdict)


def test_what_grows_grows_at_any_start(tmp_path: Path) -> None:
    time = np.arange(2048) / RATE
    record(tmp_path, np.exp(time) * np.sin(300 * time), start_tick=100 * RATE)
    with open_run(tmp_path) as run:
        window = measure(run, Target("a.x", ("a.x",)), 0, 2048)
        assert window.growth == pytest.approx(1.0, abs=0.1)


def carried(folder: Path, *, lost_at: int | None = None, touched_at: int = 0) -> Inspection:
    """Two copies of a box, and a finger on one that touches from a tick on, for two seconds."""
    names = ("x", "y", "theta")
    columns = [
        Column(name=f"vr_{c}.{name}", unit="", is_float=True, meaning=each)
        for c in "ab"
        for name, each in zip(names, POSE, strict=True)
    ]
    slot = Slot(None, 1)
    columns += [
        Column(
            name="vr_a.state",
            unit="",
            is_float=False,
            meaning=Meaning.CONTACT_STATE,
            belongs_to=slot,
        )
    ]
    cells = np.zeros((2048, 7), dtype=np.int64)
    cells[touched_at:, 6] = 2
    if lost_at is not None:
        cells[lost_at:, 3] = np.array([np.nan]).view(np.int64)[0]
    group = RecordGroup(name="control", period=1, columns=tuple(columns))
    write(folder / "run.h5", (group,), (cells,))
    return Inspection(open_run(folder))


def test_a_copy_that_is_nowhere_has_drifted_from_the_other(tmp_path: Path) -> None:
    measured = carried(tmp_path / "whole")
    assert measured.value("drift") == measured.value("drift_rms") == 0.0
    measured = carried(tmp_path / "lost", lost_at=500)
    for name in ("drift", "drift_rms", "box_displacement"):
        assert np.isnan(measured.value(name)), name
    assert measured.value("drift", (0, 500)) == 0.0


def test_a_box_that_is_grasped_as_the_run_ends_was_not_held_without_a_loss(tmp_path: Path) -> None:
    assert carried(tmp_path / "early", touched_at=10).value("contact_losses") == 0
    assert carried(tmp_path / "late", touched_at=2000).value("contact_losses") is None


GROUPS = (
    RecordGroup(name="control", period=1, columns=(Column(name="a.x", unit="m", is_float=True),)),
    RecordGroup(name="late", period=8, columns=(Column(name="a.slow", unit="m", is_float=True),)),
)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("a.x: {max_bellow: 1}", "Did you mean max_below"),
        ("a.y: {max_below: 1}", "a.y is not a recorded signal"),
        ("contact_loses: {equals: 0}", "Did you mean contact_losses"),
        ("a.x: {max_below: high}", "high"),
        ("a.x: {max_below: 1 N}", "1 N"),
        ("a.x: {max_below: [1, 2]}", "one number"),
        ("a.x: {max_within: [2, 1]}", "above the high end"),
        ("a.x: {max_below: 1, from: 3}", "no time within the 2 s"),
        ("a.x: {max_below: 1, from: 1, to: 0.5}", "no time within"),
        ("a.x: {max_below: 1, to: 2.002}", "without 'to' the window lasts to its end"),
        ("a.x: {std_below: 1, to: 0}", "one sample of a.x, and it takes 2"),
        ("a.slow: {max_below: 1, from: 1 ms, to: 2 ms}", "no sample of a.slow, recorded every 8"),
        ("a.x: {growth_below: 1, to: 2 ms}", "3 samples of a.x, and it takes 4"),
        ("a.x: {amplitude_above: 1, frequency: 3}", "less than one period"),
        ("a.slow: {amplitude_above: 1, frequency: 500}", "too few for a period"),
        ("a.x: {max_abs_above: -1}", "cannot fail: the max_abs of a.x is at least 0"),
        ("a.x: {change_count_above: -1}", "cannot fail"),
        ("'|a.x|': {above: -1 m}", "cannot fail: the value of |a.x| is at least 0"),
        ("held_fraction: {within: [0, 1]}", "cannot fail: held_fraction is at least 0 and at most"),
        ("drift: {above: -1}", "cannot fail"),
        ("drift: {above: 0}", "nothing that is recorded tells drift"),
        ("a.x - a.x: {max_below: 1}", "both sides are the same"),
        ("a.x: {from: 1}", "expects nothing"),
        ("a.x: {amplitude_below: 1}", "frequency"),
        ("a.x: {max_below: 1, frequency: 3}", "frequency has no effect"),
        ("contact_losses: {equals: 0, frequency: 3}", "frequency has no effect"),
        ("a.x: {amplitude_below: 1, frequency: 0}", "above 0 in rad/s, not 0"),
        ("a.x: {amplitude_below: 1, frequency: -2}", "above 0 in rad/s, not -2"),
        ("drift: {max_below: 1}", "max_below is not a predicate"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_place(
    line: str, told: str, tmp_path: Path
) -> None:
    loaded = scenario(tmp_path, "expect:", f"  {line}")
    with pytest.raises(InputError, match=r"small\.yaml:9:\d+: ") as refused:
        parse_expectations(loaded, GROUPS)
    assert told in str(refused.value)
