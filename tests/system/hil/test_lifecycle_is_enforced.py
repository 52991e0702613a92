"""A device moves through its states in one order only, and FAULT is left by reset alone."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule

from cosim.base.errors import InputError
from hil.device.contract import Flag, State, Status, Watchdog, WriteOutcome
from hil.device.device import Device
from hil.device.errors import (
    ActivationRefused,
    Cause,
    DeviceError,
    DeviceFault,
    DeviceGone,
    LifecycleError,
)
from hil.device.life import Alarm
from hil.drivers.mock.driver import MockDriver
from hil.setup.device_file import parse as parse_file
from tests.support.hil.hil_bench import REST, Puppet, mock, rested, run


class Life(RuleBasedStateMachine):
    """Calls in any order; a plain table says what each may do in each state."""

    def __init__(self):
        super().__init__()
        self.puppet = Puppet()
        self.device = mock(self.puppet)
        self.state = State.UNCONFIGURED
        self.homed = False
        self.quiet = 0

    def call(self, name, allowed, after):
        before = len(self.puppet.torques)
        if self.state not in allowed:
            with pytest.raises(LifecycleError):
                getattr(self.device, name)()
            assert len(self.puppet.torques) == before
        else:
            self.device.driver.body = self.device.driver.body or self.puppet
            getattr(self.device, name)()
            self.state = after
        assert self.device.state is self.state

    @rule()
    def configure(self):
        fresh = self.state is State.UNCONFIGURED
        self.call("configure", {State.UNCONFIGURED}, State.INACTIVE)
        if fresh:
            self.homed = False

    @rule()
    def home(self):
        was = self.state
        self.call("home", {State.INACTIVE}, State.INACTIVE)
        if was is State.INACTIVE:
            self.homed, self.quiet = True, 0

    @rule()
    def activate(self):
        if self.state is State.INACTIVE and not (self.homed and self.quiet >= 32):
            with pytest.raises(ActivationRefused):
                self.device.activate()
        else:
            self.call("activate", {State.INACTIVE}, State.ACTIVE)

    @rule()
    def deactivate(self):
        self.call("deactivate", {State.ACTIVE}, State.INACTIVE)

    @rule()
    def reset(self):
        self.call("reset", {State.FAULT}, State.UNCONFIGURED)
        if self.device.state is State.UNCONFIGURED:
            self.homed = False

    @rule()
    def close(self):
        self.device.close()
        self.state, self.homed = State.UNCONFIGURED, False

    @precondition(lambda self: self.state is not State.UNCONFIGURED)
    @rule()
    def forty_ticks(self):
        sent = run(self.device, 40, (0.002, 0.002))
        self.quiet += 40
        if self.state is not State.ACTIVE:
            assert all(torque == (0.0, 0.0) for torque in self.puppet.torques[-40:])
        else:
            assert sent[-1][1].torque != (0.0, 0.0)

    @precondition(lambda self: self.state is State.ACTIVE)
    @rule()
    def not_a_number(self):
        self.device.read(0)
        self.device.write(0, (float("nan"), 0.0))
        assert self.puppet.torques[-1] == (0.0, 0.0)
        self.state = State.FAULT
        assert self.device.state is State.FAULT


Life.TestCase.settings = settings(deadline=None, max_examples=40, stateful_step_count=15)
TestLife = Life.TestCase


def test_a_driver_knows_nothing_of_what_stands_between_command_and_motor():
    """It has no device, no safety layer, no state and no permission to change."""
    device = mock(Puppet())
    held = {id(value) for value in vars(device.driver).values()}
    for part in (device, device.safety, device._life, device._samples, device.permission):
        assert id(part) not in held
    assert Device.__final__


def test_without_a_permission_torque_is_computed_and_zero_is_sent():
    puppet = Puppet()
    device = rested(mock(puppet, output=False))
    device.activate()
    exchanged = run(device, 2000, (0.01, -0.01))
    assert set(puppet.torques) == {(0.0, 0.0)}
    assert exchanged[-1][1].limited == pytest.approx((0.01, -0.01))
    assert exchanged[-1][1].torque == (0.0, 0.0)
    assert all(sent.flags & Flag.DRY for _, sent in exchanged)
    assert not exchanged[-1][0].status & Status.OUTPUT_ENABLED


def test_an_unhomed_device_refuses_activation():
    device = mock(Puppet())
    device.configure()
    run(device, 64)
    with pytest.raises(ActivationRefused, match="not homed"):
        device.activate()


def test_a_moving_device_refuses_activation():
    puppet = Puppet()
    device = rested(mock(puppet))
    for tick in range(64):
        puppet.put((REST[0] + 0.03 * tick / 1024, REST[1]))
        device.read(tick)
        device.write(tick, (0.0, 0.0))
    with pytest.raises(ActivationRefused, match="rest"):
        device.activate()


def test_a_device_outside_its_workspace_refuses_activation():
    file = parse_file(
        {
            "driver": "mock",
            "workspace": {"left": 0.0, "right": 0.045, "bottom": 0.1, "top": 0.21},
        }
    )
    puppet = Puppet()
    device = rested(mock(puppet, file=file))
    for step in range(20):
        puppet.put((REST[0] + 0.0005 * step, REST[1]))
        run(device, 1, start=step)
    run(device, 40, start=20)
    with pytest.raises(ActivationRefused, match="workspace"):
        device.activate()


def test_a_large_first_command_is_refused_with_zero():
    puppet = Puppet()
    device = rested(mock(puppet))
    device.activate()
    device.read(0)
    sent = device.write(0, (0.05, 0.0))
    assert sent.torque == puppet.torques[-1] == (0.0, 0.0)
    assert device.fault is not None
    assert device.fault.cause is Cause.FIRST_COMMAND


def test_a_jump_unhomes_and_nothing_brings_the_device_back_by_itself():
    puppet = Puppet()
    device = rested(mock(puppet))
    device.activate()
    run(device, 10, (0.005, 0.0))
    puppet.put((REST[0] + 0.03, REST[1]))
    run(device, 200, (0.005, 0.0), start=10)
    assert device.state is State.FAULT
    assert not device.homed
    assert set(puppet.torques[-200:]) == {(0.0, 0.0)}
    with pytest.raises(DeviceFault, match="jumped"):
        device.raise_fault()
    device.reset()
    device.driver.body = puppet
    device.configure()
    assert not device.homed


@pytest.mark.parametrize("way", ["reset", "close"])
def test_what_was_in_fault_and_is_opened_again_can_fault_again(way: str):
    device = rested(mock(Puppet()))
    for opening in range(3):
        device.activate()
        run(device, 20, (0.005, 0.0))
        assert device.state is State.ACTIVE, opening
        run(device, 20, (float("nan"), 0.0))
        assert device.state is State.FAULT, opening
        getattr(device, way)()
        device.driver.body = Puppet()
        rested(device)
        assert device.fault is None


class Failing(Puppet):
    """A mechanism whose port breaks at a given step."""

    def __init__(self, after):
        super().__init__()
        self.after = after

    def step(self, torque):
        if len(self.torques) >= self.after:
            raise DeviceGone("the port is gone")
        super().step(torque)


def test_an_error_while_writing_becomes_a_fault_whose_output_is_unknown_or_left_to_the_watchdog():
    puppet = Failing(after=50)
    device = rested(mock(puppet))
    device.activate()
    run(device, 60, (0.005, 0.0))
    assert device.state is State.FAULT
    assert device.outcome is WriteOutcome.WATCHDOG
    with pytest.raises(DeviceFault, match="watchdog"):
        device.raise_fault()


def test_without_a_watchdog_the_output_is_unknown_then(monkeypatch):
    monkeypatch.setattr(MockDriver, "watchdog", Watchdog())
    puppet = Failing(after=50)
    device = rested(mock(puppet))
    device.activate()
    run(device, 60, (0.005, 0.0))
    assert device.outcome is WriteOutcome.UNKNOWN
    with pytest.raises(DeviceFault, match="cut the power"):
        device.raise_fault()


def test_the_loop_coming_back_late_is_answered_with_zero_and_fault():
    now = [0.0]
    puppet = Puppet()
    device = rested(mock(puppet, clock=lambda: now[0]))
    device.activate()
    for tick in range(100):
        now[0] += 1 / 1024
        device.read(tick)
        device.write(tick, (0.005, 0.0))
    assert puppet.torques[-1] != (0.0, 0.0)
    now[0] += 0.0125
    device.read(100)
    assert Flag.ZEROING in device.write(100, (0.005, 0.0)).flags
    assert puppet.torques[-1] == (0.0, 0.0)
    assert device.fault is not None
    assert device.fault.cause is Cause.LATE
    device.read(101)
    assert device.write(101, (0.005, 0.0)).torque == (0.0, 0.0)


def pair_of_devices():
    """Two active devices of one run, each with its puppet, pushing."""
    alarm, puppets = Alarm(), (Puppet(), Puppet())
    devices = [rested(mock(puppet, alarm=alarm)) for puppet in puppets]
    for device in devices:
        device.activate()
    for _ in range(100):
        exchange_both(devices)
    assert all(puppet.torques[-1] != (0.0, 0.0) for puppet in puppets)
    return devices, puppets


def exchange_both(devices, commands=((0.005, 0.0), (0.005, 0.0))):
    for device in devices:
        device.read(0)
    for device, command in zip(devices, commands, strict=True):
        device.write(0, command)


def test_a_fault_found_while_reading_zeroes_the_other_device_in_the_same_tick():
    devices, puppets = pair_of_devices()
    puppets[1].put((REST[0] + 0.03, REST[1]))
    exchange_both(devices)
    assert [device.state for device in devices] == [State.FAULT, State.FAULT]
    assert all(puppet.torques[-1] == (0.0, 0.0) for puppet in puppets)
    assert devices[0].fault.cause is Cause.SIBLING


def test_a_fault_found_while_writing_zeroes_the_other_device_at_the_next_tick():
    devices, puppets = pair_of_devices()
    exchange_both(devices, ((0.005, 0.0), (float("nan"), 0.0)))
    assert puppets[0].torques[-1] != (0.0, 0.0), "it had written already"
    exchange_both(devices)
    assert all(puppet.torques[-1] == (0.0, 0.0) for puppet in puppets)


def test_close_zeroes_on_every_path():
    for breaking in (None, RuntimeError):
        puppet = Puppet()
        device = rested(mock(puppet))
        try:
            with device:
                device.activate()
                run(device, 100, (0.005, 0.0))
                assert puppet.torques[-1] != (0.0, 0.0)
                if breaking is not None:
                    raise breaking("anything")
        except RuntimeError:
            pass
        assert puppet.torques[-1] == (0.0, 0.0)
        assert device.state is State.UNCONFIGURED
        device.close()


def test_a_device_that_is_too_slow_or_someone_elses_is_refused(monkeypatch):
    slow = mock(Puppet())
    monkeypatch.setattr(MockDriver, "native_period_ticks", 2.5)
    with pytest.raises(InputError, match="too slow"):
        slow.configure()
    monkeypatch.undo()
    other = mock(Puppet(), file=parse_file({"driver": "mock", "serial": "A17"}))
    monkeypatch.setattr(MockDriver, "serial", lambda self: "B4")
    with pytest.raises(DeviceError, match=r"B4.*A17"):
        other.configure()
    assert other.state is State.UNCONFIGURED
