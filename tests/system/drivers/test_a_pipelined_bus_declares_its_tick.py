"""``?pipelined=1``: nobody waits on the bus, a tick is declared, no zero is confirmed early."""

from __future__ import annotations

from math import nan

import pytest

from cosim.base.errors import InputError
from hil.device.contract import State, WriteOutcome
from hil.device.fault_latch import SETTLE_TICKS
from hil.setup.address import parse
from hil.setup.registry import find
from tests.support.hil.canopen_bench import Wire
from tests.support.hil.motor_wire import SOUND, WireFault, on_motors
from tests.support.hil.motors.slcan import Lines, line

BOARDS = ("canopen", "cia402")
PUSH = (0.008, -0.008)


def without_sdo(answer: bytes) -> bytes:
    frames = Lines().frames(answer)
    return b"".join(line(name, data) for name, data in frames if name & 0x780 != 0x580)


@pytest.mark.parametrize("name", BOARDS)
def test_it_is_off_unless_asked_for_and_costs_a_tick(name: str):
    kind = find(name)
    assert kind.latency_of(parse(f"{name}+socketcan://can0")) == kind.latency_ticks == 0
    assert kind.latency_of(parse(f"{name}+socketcan://can0?pipelined=1")) == 1
    with pytest.raises(InputError, match="pipelined"):
        kind.latency_of(parse(f"{name}+socketcan://can0?pipelined=yes"))


@pytest.mark.parametrize("name", BOARDS)
def test_what_is_read_answers_the_last_ticks_sync(name: str, monkeypatch: pytest.MonkeyPatch):
    """A tick without an answer is one without a sample, a tick later."""
    with on_motors(f"{name}, pipelined", monkeypatch) as (device, wire):
        ages = []
        for tick in range(12):
            wire.now = WireFault(lose_answers=True) if tick == 5 else SOUND
            ages.append(device.read(tick).sample_age)
            device.write(tick, (0.0, 0.0))
            wire.tick()
    assert ages == [int(tick == 6) for tick in range(12)]


@pytest.mark.parametrize("spoil", [None, without_sdo], ids=["answered", "no SDO answers"])
@pytest.mark.parametrize("name", BOARDS)
def test_a_zero_is_confirmed_by_an_answer_to_a_question_after_it_alone(
    name: str, spoil, monkeypatch: pytest.MonkeyPatch
):
    """Process data go on, and say zero; but they may be older than the zero."""
    with on_motors(f"{name}, pipelined", monkeypatch) as (device, wire):
        for tick in range(200):
            device.read(tick)
            device.write(tick, PUSH if tick < 199 else (nan, 0.0))
            wire.tick()
        assert device.state is State.FAULT
        wire.now = WireFault(spoil=spoil)
        for tick in range(200, 200 + 2 * SETTLE_TICKS):
            device.read(tick)
            device.write(tick, PUSH)
            wire.tick()
        confirmed = device.outcome is WriteOutcome.ZERO_CONFIRMED
        assert confirmed is (spoil is None)
        assert wire.on_wire == (0.0, 0.0)


def test_devices_of_one_bus_agree():
    wire = Wire((1,), (2,))
    try:
        first, second = wire.device("1"), wire.device("2&pipelined=1")
        first.configure()
        with pytest.raises(InputError, match="disagree about 'pipelined'"):
            second.configure()
    finally:
        wire.close()
