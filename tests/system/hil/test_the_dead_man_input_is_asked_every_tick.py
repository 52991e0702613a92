"""Force lasts as long as the dead-man input is held: released, it is zero at the next tick."""

from __future__ import annotations

import os
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from hil.device.component import observe_rest
from hil.device.contract import State, WriteOutcome
from hil.device.errors import ActivationRefused, Cause
from hil.safety.dead_man import EventKey, open_dead_man
from hil.safety.permission import dead_man
from hil.setup.session import Session
from tests.support.hil.driver_bench import Bench, Rig
from tests.support.hil.hil_bench import Puppet, mock, rested, run

SPACE, OTHER = 57, 30
KEY, SYNC, DROPPED = 1, 0, 3
UP, DOWN, REPEAT = 0, 1, 2
PUSH = (0.005, 0.0)


def event(kind: int, code: int, value: int) -> bytes:
    return struct.pack("@llHHi", 0, 0, kind, code, value)


def configured(bench: Bench, name: str) -> Rig:
    emulator = bench.emulator(name)
    rig = Rig(bench.device(name, emulator, output=False), emulator)
    rig.device.configure()
    return rig


@pytest.fixture
def pedal(tmp_path):
    """(path, descriptor to press it with): a pipe that carries what the kernel would."""
    path = str(tmp_path / "event0")
    os.mkfifo(path)
    writer = os.open(path, os.O_RDWR)
    yield path, writer
    os.close(writer)


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
    st.lists(
        st.tuples(
            st.sampled_from([KEY, SYNC]),
            st.sampled_from([SPACE, OTHER, DROPPED]),
            st.sampled_from([UP, DOWN, REPEAT]),
        )
    )
)
def test_a_key_is_held_between_press_and_release_and_at_no_other_time(events):
    """Against a plain reading of the list; a stuck key only repeats, so it is never held."""
    reader, writer = os.pipe()
    try:
        key = EventKey(f"/dev/fd/{reader}", SPACE)
        expected = False
        for kind, code, value in events:
            os.write(writer, event(kind, code, value))
            if (kind, code) == (SYNC, DROPPED):
                expected = False
            elif (kind, code) == (KEY, SPACE) and value != REPEAT:
                expected = value == DOWN
            assert key() is expected
        assert key() is expected
        key.close()
        assert not key()
    finally:
        os.close(reader)
        os.close(writer)


def test_a_pulled_plug_is_a_release():
    reader, writer = os.pipe()
    key = EventKey(f"/dev/fd/{reader}")
    os.write(writer, event(KEY, OTHER, DOWN))
    assert key(), "any key of the device, where none is named"
    os.close(writer)
    assert not key()
    assert not key()
    key.close()
    os.close(reader)


def test_sources_that_cannot_be_used_are_sentences(bench: Bench):
    for wrong in ("keyboard", "evdev:", "evdev:/dev/input/event5?button=1", "evdev:/x?key=a"):
        with pytest.raises(InputError, match=r"dead-man|key=CODE"):
            open_dead_man(wrong)
    with pytest.raises(InputError, match="cannot be opened"):
        open_dead_man("evdev:/dev/input/none-such")
    haply = bench.device("haply", bench.emulator("haply"))
    with pytest.raises(InputError, match="tells of no switch"):
        open_dead_man("device")(haply)


def test_a_pedal_permits_and_releases_a_device_in_lock_step(pedal, bench: Bench):
    path, press = pedal
    rig = configured(bench, "haply")
    session = Session(enable_output=True, yes=True, dead_man=open_dead_man(f"evdev:{path}?key=57"))
    os.write(press, event(KEY, SPACE, DOWN))
    rig.device.permission = session.permission(rig.device)
    assert rig.device.permission.how == "emulator, proved, dead-man input held"
    rig.device.home()
    observe_rest(rig.device)
    rig.device.activate()
    rig.exchange(200, PUSH)
    assert rig.truth()["torque"] != [0.0, 0.0]
    os.write(press, event(KEY, SPACE, UP))
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
