"""A time series has the record's values: no spike is dropped, no time invented, no unit mixed."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cosim.base.errors import InputError
from cosim.base.recording import Column, RecordGroup
from cosim.plot.kinds import difference, histogram, over_time, phase_plane, spectrum
from cosim.plot.series import Span, held_together, reduced, select
from cosim.record.reader import open_run
from tests.support.record.synthetic_run import write

WHOLE = Span()


@given(
    arrays(np.float64, st.integers(1, 5000), elements=st.floats(-1e9, 1e9)),
    st.integers(2, 400).map(lambda half: 2 * half),
)
def test_no_extreme_is_lost(values: np.ndarray, points: int) -> None:
    time = np.arange(values.size) / 1024
    kept_time, kept = reduced(time, values, points)
    assert kept.size <= points + 2
    assert {kept.min(), kept.max(), kept[0], kept[-1]} == {
        values.min(),
        values.max(),
        values[0],
        values[-1],
    }
    assert (np.diff(kept_time) > 0).all()
    assert (values[np.searchsorted(time, kept_time)] == kept).all()


@pytest.mark.parametrize("points", [10, 64])
def test_every_spike_of_a_row_is_drawn(points: int) -> None:
    for place in range(1000):
        values = np.zeros(1000)
        values[place] = 1.0
        assert reduced(np.arange(1000.0), values, points)[1].max() == 1.0


def pair(folder: Path, periods: tuple[int, int]) -> Path:
    """A run with two signals, each of which is its own tick."""
    ticks = [np.arange(0, 240, period) for period in periods]
    write(
        folder / "run.h5",
        tuple(
            RecordGroup(
                name=f"rate_{number}",
                period=period,
                columns=(Column(name=f"a.s{number}", unit="m", is_float=True),),
            )
            for number, period in enumerate(periods)
        ),
        tuple(each.astype(np.float64)[:, None].view(np.int64) for each in ticks),
    )
    return folder


@pytest.mark.parametrize("periods", [(1, 8), (8, 1), (2, 3), (5, 5), (7, 3)])
def test_the_slower_one_is_held(periods: tuple[int, int], tmp_path: Path) -> None:
    with open_run(pair(tmp_path, periods)) as run:
        first, second = select([run], ["a.s0", "a.s1"])
        time, one, two = held_together(first, second, WHOLE)
    ticks = np.rint(time * float(run.base_rate)).astype(int)
    assert (np.diff(ticks) == min(periods)).all()
    assert one.tolist() == [tick - tick % periods[0] for tick in ticks]
    assert two.tolist() == [tick - tick % periods[1] for tick in ticks]


@pytest.mark.parametrize(("start", "until"), [("0", None), ("1/2", "1"), ("0.9999", "1.0001")])
def test_a_span_is_what_is_asked_for(start: str, until: str | None, small_run: Path) -> None:
    span = Span(Fraction(start), None if until is None else Fraction(until))
    with open_run(small_run) as run:
        (series,) = select([run], ["a.ramp"])
        time, values = series.values(span)
        every = run["a.ramp"].group.time
        inside = every >= float(span.start)
        if span.until is not None:
            inside &= every <= float(span.until)
        assert time.tolist() == every[inside].tolist()
        assert values.tolist() == run["a.ramp"].values[inside].tolist()


def test_a_spectrum_has_the_power_of_its_signal_at_its_frequency(small_run: Path) -> None:
    """Parseval: the sum over the bins is the variance, 1/2 of a sine of 1 N at 4 Hz."""
    with open_run(small_run) as run:
        (panel,) = spectrum(select([run], ["a.sine"]), WHOLE)
    (line,) = panel.lines
    assert panel.y == "N/√Hz"
    assert line.x[line.y.argmax()] == pytest.approx(4.0, abs=1.0)
    assert (line.y**2).sum() * (line.x[1] - line.x[0]) == pytest.approx(0.5, rel=0.02)


def test_shares_add_up_to_one(small_run: Path) -> None:
    with open_run(small_run) as run:
        panels = histogram(select([run], ["a.*"]), WHOLE)
    assert {panel.x for panel in panels} == {"m", "N", "1"}
    for panel in panels:
        for line in panel.lines:
            assert line.y.sum() == pytest.approx(1.0, abs=1e-12)
            assert line.x.size == line.y.size + 1
    (whole,) = (panel for panel in panels if panel.x == "1")
    assert whole.lines[0].x.tolist() == [-0.5, 0.5, 1.5, 2.5, 3.5]


def test_a_run_and_itself_differ_by_nothing(small_run: Path) -> None:
    with open_run(small_run) as run:
        (first,) = select([run], ["a.sine"])
        again = type(first)(run, first.signal, "again")
        (panel,) = difference([first, again], WHOLE)
    assert not panel.lines[0].y.any()


def test_each_unit_has_a_panel_of_its_own(small_run: Path) -> None:
    with open_run(small_run) as run:
        panels = over_time(select([run], ["a.*", "lan.held"]), WHOLE)
    assert [panel.y for panel in panels] == ["m", "N", "1", "m/s"]


@pytest.mark.parametrize(
    ("draw", "patterns", "sentence"),
    [
        (difference, ["a.ramp", "a.sine"], "they have no difference"),
        (difference, ["a.ramp"], "name a second signal"),
        (phase_plane, ["a.*"], "takes two signals of a run"),
        (over_time, ["a.rampe"], "Did you mean a.ramp?"),
        (over_time, ["b.*"], "nothing recorded in it matches"),
    ],
)
def test_what_cannot_be_drawn_is_refused(draw, patterns, sentence, small_run: Path) -> None:
    with open_run(small_run) as run, pytest.raises(InputError, match=sentence.replace("?", r"\?")):
        draw(select([run], patterns), WHOLE)


def test_a_span_without_a_row_is_refused(small_run: Path) -> None:
    with open_run(small_run) as run, pytest.raises(InputError, match="has no row from 7 s"):
        over_time(select([run], ["a.ramp"]), Span(Fraction(7)))
