"""Sub-steps, fixed steps, early return, and time: what an FMU's doStep is given."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fmus.probe
from cosim.base.errors import InputError, RunError
from cosim.master.assembly.clock import HYPERPERIOD_LIMIT, Clock
from cosim.master.assembly.plan import due_together
from cosim.master.fmu.instance import Fmu
from tests.support.master.master_support import run, scenario_of


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_a_fixed_step_is_taken_as_often_as_it_fits(tmp_path: Path, flavour: str) -> None:
    probe = str(fmus.probe.find("probe_fixed_step", flavour))
    written = {"duration": 0.125, "components": {"p": {"fmu": probe, "rate": 128}}}
    sink, _ = run(scenario_of(tmp_path, written))
    np.testing.assert_array_equal(sink.signal("p.steps"), np.arange(16) * 8)
    np.testing.assert_array_equal(sink.signal("p.end"), np.arange(16) / 128)


def test_a_step_that_is_too_long_is_an_error_and_substeps_help(tmp_path: Path) -> None:
    probe: dict[str, Any] = {"fmu": str(fmus.probe.find("probe_substeps")), "rate": 1024}
    written = {"duration": 0.125, "components": {"p": probe}}
    with pytest.raises(RunError, match=r"p returned status 'discard'.*the longest is"):
        run(scenario_of(tmp_path, written))
    probe["substeps"] = 4
    sink, _ = run(scenario_of(tmp_path, written))
    np.testing.assert_array_equal(sink.signal("p.steps"), np.arange(128) * 4)
    np.testing.assert_allclose(sink.signal("p.integral"), np.arange(128) / 1024, rtol=1e-12)


STEP3 = ctypes.CFUNCTYPE(
    ctypes.c_int,
    ctypes.c_void_p,
    ctypes.c_double,
    ctypes.c_double,
    ctypes.c_bool,
    *[ctypes.POINTER(ctypes.c_bool)] * 3,
    ctypes.POINTER(ctypes.c_double),
)


def with_step(monkeypatch: pytest.MonkeyPatch, function: Any) -> None:
    """Let every FMU step with ``function``."""
    native = STEP3(function)
    address = ctypes.cast(native, ctypes.c_void_p).value
    monkeypatch.setattr(Fmu, "do_step", property(lambda self, keep=native: address))


def raising_flag(flag: int) -> Callable[..., int]:
    def step(*arguments: Any) -> int:
        if arguments[1] == 3 / 1024:
            arguments[flag][0] = True
        return 0

    return step


def test_early_return_is_refused_politely(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with_step(monkeypatch, raising_flag(6))
    written = {"duration": 0.1, "components": {"hand": {"fmu": "hand", "rate": 1024}}}
    with pytest.raises(RunError, match=r"hand returned early.*at tick 3"):
        run(scenario_of(tmp_path, written))


def test_a_model_that_asks_for_the_end_ends_the_run_well(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_step(monkeypatch, raising_flag(5))
    written = {"duration": 0.1, "components": {"hand": {"fmu": "hand", "rate": 1024}}}
    sink, simulation = run(scenario_of(tmp_path, written))
    outcome = simulation.outcome
    assert outcome.ended_by == "hand asked to end the simulation at tick 3 (0.00292969 s)"
    assert not outcome.interrupted
    assert outcome.ticks == len(sink.signal("hand.position")) == 4


def test_a_warning_is_counted_and_pending_ends_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = {"duration": 0.1, "components": {"hand": {"fmu": "hand", "rate": 1024}}}
    with_step(monkeypatch, lambda *arguments: 1)
    _, simulation = run(scenario_of(tmp_path, written))
    assert simulation.outcome.warnings == {"hand": 103}
    with_step(monkeypatch, lambda *arguments: 5)
    with pytest.raises(RunError, match="'pending' from its step at tick 0"):
        run(scenario_of(tmp_path, written))


@pytest.mark.parametrize("rate", ["1024", "1000", "333.3"])
def test_time_is_a_multiple_of_the_tick_rounded_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rate: str
) -> None:
    times: list[tuple[float, float]] = []
    with_step(monkeypatch, lambda *arguments: times.append((arguments[1], arguments[2])) or 0)
    hand = {"fmu": "hand", "rate": float(Fraction(rate)), "substeps": 3}
    scenario = scenario_of(tmp_path, {"duration": 1, "components": {"hand": hand}})
    run(scenario, until=40)
    tick = 1 / scenario.base_rate
    period = scenario.components["hand"].period
    expected = [float((k + Fraction(j * period, 3)) * tick) for k in range(40) for j in range(3)]
    assert [time for time, _ in times] == expected
    assert {step for _, step in times} == {float(period * tick / 3)}


@settings(deadline=None)
@given(
    st.fractions(min_value=Fraction(1, 10), max_value=100_000, max_denominator=1000),
    st.integers(0, 10**9),
)
def test_seconds_are_the_nearest_double(rate: Fraction, tick: int) -> None:
    assert Clock(rate).seconds(tick) == float(Fraction(tick) / rate)


@settings(deadline=None)
@given(st.lists(st.integers(1, 12), min_size=1, max_size=5))
def test_every_tick_has_exactly_the_periods_that_are_due(periods: list[int]) -> None:
    hyperperiod = Clock(Fraction(1024)).hyperperiod(periods)
    due, pattern = due_together(periods, hyperperiod)
    assert len(pattern) == hyperperiod
    for tick, number in enumerate(pattern.tolist()):
        assert due[number] == {period for period in periods if tick % period == 0}


def test_a_pattern_that_never_repeats_is_refused() -> None:
    with pytest.raises(InputError, match="divide each other"):
        Clock(Fraction(1)).hyperperiod([HYPERPERIOD_LIMIT + 1])
