"""A sleep is a fault after waking; before it, boards without a watchdog need a machine that stays
awake."""

from __future__ import annotations

from pathlib import Path
from time import CLOCK_BOOTTIME, monotonic
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.base.system.sleep import LONGEST_STEP, SleepWatch, Wakefulness, can_sleep
from hil.device.contract import Flag, State
from hil.device.errors import ActivationRefused, Cause
from hil.setup.session import Session
from tests.support.hil.hil_bench import Puppet, mock, rested, run


class Clocks:
    """Two clocks, of which one stands still in sleep; each look takes its time."""

    def __init__(self, looks: list[float], offset: float) -> None:
        self.now, self.asleep, self._looks = 0.0, offset, iter(looks)

    def going(self) -> float:
        self.now += next(self._looks, 0.0)
        return self.now

    def all_along(self) -> float:
        self.now += next(self._looks, 0.0)
        return self.now + self.asleep


@given(
    st.lists(st.floats(0.0, 0.5), max_size=60),
    st.floats(-1e-6, 1e6),
    st.floats(2 * LONGEST_STEP, 1e5),
)
def test_only_a_sleep_is_one(looks: list[float], offset: float, sleep: float):
    clocks = Clocks(looks, offset)
    watch = SleepWatch(clocks.going, clocks.all_along)
    assert [watch.slept() for _ in range(20)] == [0.0] * 20, "a busy machine has not slept"
    clocks.asleep += sleep
    assert watch.slept() == pytest.approx(sleep, abs=LONGEST_STEP)
    assert watch.slept() == 0.0


def test_a_sleep_is_answered_with_zero_and_fault():
    device = rested(mock(Puppet(), clock=lambda: 0.0))
    device.activate()
    run(device, 20, (0.001, 0.0))
    assert device.state is State.ACTIVE
    clocks = Clocks([], 0.0)
    device._around.sleep = SleepWatch(clocks.going, clocks.all_along)
    run(device, 2, (0.001, 0.0))
    clocks.asleep = 8.0
    puppet = device.driver.body
    ((_, sent),) = run(device, 1, (0.001, 0.0))
    assert puppet.torques[-1] == (0.0, 0.0)
    assert Flag.ZEROING in sent.flags
    assert device.fault is not None
    assert device.fault.cause is Cause.SLEPT
    assert "8.0 s" in device.fault.sentence
    assert not device.homed


def test_a_machine_without_states_of_sleep_needs_nothing(tmp_path: Path):
    (tmp_path / "state").write_text("\n")
    assert not can_sleep(tmp_path / "state")
    assert not can_sleep(tmp_path / "none")
    assert Wakefulness().keep(states=tmp_path / "state", command=["/nowhere"]) is None


def test_it_is_kept_awake_until_it_is_let_go_of(tmp_path: Path):
    (tmp_path / "state").write_text("freeze mem disk\n")
    awake, mark = Wakefulness(), tmp_path / "over"
    command = ["sh", "-c", f"echo held; cat; echo > {mark}"]
    assert awake.keep(states=tmp_path / "state", command=command) is None
    process = awake._process
    assert process is not None
    assert process.poll() is None
    awake.let_go()
    assert process.poll() is not None


@pytest.mark.parametrize("command", [["/nowhere"], ["false"], ["sleep", "60"]])
def test_who_does_not_grant_it_is_named(tmp_path: Path, command: list[str]):
    (tmp_path / "state").write_text("mem\n")
    said = Wakefulness().keep(states=tmp_path / "state", command=command, wait=0.2)
    assert said is not None
    assert command[0] in said


@pytest.mark.parametrize("protects", [True, False])
def test_no_force_for_a_board_without_watchdog_on_a_machine_that_may_sleep(protects: bool):
    session = Session()
    session.wakefulness = SimpleNamespace(keep=lambda: "nobody grants it", let_go=lambda: None)
    device = SimpleNamespace(
        name="haply:///dev/x",
        in_process=False,
        watchdog=SimpleNamespace(protects=protects),
        permission=SimpleNamespace(how="confirmed at the prompt"),
    )
    if protects:
        session.keep_awake(device)
        return
    with pytest.raises(ActivationRefused, match="fall asleep"):
        session.keep_awake(device)
    device.permission = SimpleNamespace(how="emulator, proved")
    session.keep_awake(device)


def test_a_device_compares_the_clock_that_counts_sleep_with_the_one_that_does_not(monkeypatch):
    """CLOCK_BOOTTIME against CLOCK_MONOTONIC (clock_gettime(2)): the first goes on in sleep."""
    asleep = 0.0
    monkeypatch.setattr("time.clock_gettime", lambda clock: float(clock == CLOCK_BOOTTIME) * asleep)
    device = mock(Puppet(), clock=lambda: 0.0)
    watch = device._around.sleep
    watch._going = lambda: 0.0
    assert watch.slept() == 0.0
    asleep = 3.0
    assert watch.slept() == pytest.approx(3.0)
    assert SleepWatch()._going is monotonic
