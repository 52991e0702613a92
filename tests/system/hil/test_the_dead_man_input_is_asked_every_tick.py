"""Force lasts as long as the dead-man input is held: released, it is zero at the next tick."""

from __future__ import annotations

import errno
import os

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from hil.device.component import observe_rest
from hil.device.contract import State, WriteOutcome
from hil.device.errors import ActivationRefused, Cause
from hil.safety.dead_man import EventKey, keys_down, open_dead_man
from hil.safety.permission import dead_man
from hil.setup.session import Session
from tests.support.hil.driver_bench import Bench, Rig
from tests.support.hil.hil_bench import Puppet, mock, rested, run

SPACE, OTHER = 57, 30
PUSH = (0.005, 0.0)


class Keyboard:
    """What the kernel says is down, whoever grabs the events; ``None`` once it is unplugged."""

    def __init__(self) -> None:
        self.down: set[int] | None = set()

    def __call__(self, descriptor: int) -> int:
        if self.down is None:
            raise OSError(errno.ENODEV, "No such device")
        return sum(1 << key for key in self.down)


@pytest.fixture
def keyboard(monkeypatch) -> Keyboard:
    made = Keyboard()
    monkeypatch.setattr("hil.safety.dead_man.keys_down", made)
    return made


def configured(bench: Bench, name: str) -> Rig:
    emulator = bench.emulator(name)
    rig = Rig(bench.device(name, emulator, output=False), emulator)
    rig.device.configure()
    return rig


def test_a_released_input_is_zero_in_the_same_write_and_latched():
    held, puppet = [True], Puppet()
    device = rested(mock(puppet, output=False))
    device.permission = dead_man("mock", lambda: held[0])
    device.activate()
    run(device, 300, PUSH)
    assert puppet.torques[-1] != (0.0, 0.0)
    held[0] = False
    run(device, 1, PUSH, start=300)
    assert puppet.torques[-1] == (0.0, 0.0)
    assert device.state is State.FAULT
    assert device.fault is not None
    assert device.fault.cause is Cause.DEAD_MAN
    assert device.homed, "letting go is no reason to home again"
    held[0] = True
    run(device, 50, PUSH, start=301)
    assert set(puppet.torques[-50:]) == {(0.0, 0.0)}, "holding it again brings nothing back"
    assert device.outcome is WriteOutcome.ZERO_CONFIRMED


def test_it_has_to_be_held_to_begin():
    with pytest.raises(ActivationRefused, match="not held"):
        dead_man("mock", lambda: False)


@settings(deadline=None, max_examples=60)
@given(
    stuck=st.sets(st.sampled_from([SPACE, OTHER])),
    states=st.lists(st.sets(st.sampled_from([SPACE, OTHER]))),
    named=st.booleans(),
)
def test_a_key_is_held_while_it_is_down_and_was_seen_open_before(stuck, states, named):
    keyboard = Keyboard()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hil.safety.dead_man.keys_down", keyboard)
        keyboard.down = stuck
        key = EventKey(os.devnull, SPACE if named else None)
        open_once = {SPACE, OTHER} - stuck
        for keyboard.down in states:
            open_once |= {SPACE, OTHER} - keyboard.down
            wanted = {SPACE} if named else {SPACE, OTHER}
            assert key() is bool(keyboard.down & wanted & open_once)
        key.close()
        assert not key()


def test_a_release_is_seen_though_another_program_has_grabbed_the_events(keyboard):
    """No event comes at all: the state alone is asked."""
    key = EventKey(os.devnull, SPACE)
    keyboard.down = {SPACE}
    assert key()
    keyboard.down = set()
    assert not key()
    key.close()


def test_a_pulled_plug_is_a_release(keyboard):
    key = EventKey(os.devnull)
    keyboard.down = {OTHER}
    assert key(), "any key of the device, where none is named"
    keyboard.down = None
    assert not key()
    keyboard.down = {OTHER}
    assert not key(), "it does not come back by itself"
    key.close()


def test_what_is_no_input_device_is_refused(tmp_path):
    (tmp_path / "event0").write_text("")
    with pytest.raises(InputError, match="is no input device of Linux"):
        EventKey(str(tmp_path / "event0"))


def test_the_kernel_is_asked_as_its_header_says(monkeypatch):
    asked = []
    monkeypatch.setattr("fcntl.ioctl", lambda *arguments: asked.append(arguments))
    assert keys_down(7) == 0
    (descriptor, request, state) = asked[0]
    assert (descriptor, request, len(state)) == (7, 0x80604518, 96)


def test_sources_that_cannot_be_used_are_sentences(bench: Bench):
    for wrong in ("keyboard", "evdev:", "evdev:/dev/input/event5?button=1", "evdev:/x?key=a"):
        with pytest.raises(InputError, match=r"dead-man|key=CODE"):
            open_dead_man(wrong)
    with pytest.raises(InputError, match="cannot be opened"):
        open_dead_man("evdev:/dev/input/none-such")
    haply = bench.device("haply", bench.emulator("haply"))
    with pytest.raises(InputError, match="tells of no switch"):
        open_dead_man("device")(haply)


def test_a_pedal_permits_and_releases_a_device_in_lock_step(keyboard, bench: Bench):
    rig = configured(bench, "haply")
    session = Session(
        enable_output=True, yes=True, dead_man=open_dead_man(f"evdev:{os.devnull}?key=57")
    )
    keyboard.down = {SPACE}
    rig.device.permission = session.permission(rig.device)
    assert rig.device.permission.how == "emulator, proved, dead-man input held"
    rig.device.home()
    observe_rest(rig.device)
    rig.device.activate()
    rig.exchange(200, PUSH)
    assert rig.truth()["torque"] != [0.0, 0.0]
    keyboard.down = set()
    rig.exchange(2, PUSH)
    assert rig.truth()["torque"] == [0.0, 0.0]
    assert rig.device.fault.cause is Cause.DEAD_MAN


def test_a_switch_on_the_board_travels_in_its_answers(bench: Bench):
    rig = configured(bench, "cobs")
    pauses = iter(range(1000))

    def close_later():
        rig.emulator.control.ask("input", closed=next(pauses) > 20)

    rig.device.driver.pause = close_later
    session = Session(enable_output=True, yes=True, dead_man=open_dead_man("device"))
    rig.device.permission = session.permission(rig.device)
    rig.device.home()
    observe_rest(rig.device)
    rig.device.activate()
    rig.exchange(200, PUSH)
    assert rig.truth()["torque"] != [0.0, 0.0]
    rig.emulator.control.ask("input", closed=False)
    rig.exchange(3, PUSH)
    assert rig.truth()["torque"] == [0.0, 0.0]
    assert rig.device.fault.cause is Cause.DEAD_MAN


def test_a_switch_that_was_never_seen_open_may_be_jammed(bench: Bench, monkeypatch):
    monkeypatch.setattr("hil.safety.dead_man.PATIENCE", 0.2)
    rig = configured(bench, "cobs")
    rig.emulator.control.ask("input", closed=True)
    session = Session(enable_output=True, yes=True, dead_man=open_dead_man("device"))
    with pytest.raises(ActivationRefused, match="not seen open"):
        session.permission(rig.device)
