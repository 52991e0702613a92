"""Of a tick's answers one alone may say what ends in FAULT: an older one, or one node's."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from hil.device.contract import State
from tests.support.hil.motor_wire import SOUND, on_motors
from tests.support.hil.reply_table import TABLE, Said
from tests.support.hil.spoiled_replies import INPUT, Spoil, can, cobs, packed, without

BEFORE = 150
TOGETHER = 2
"""An answer that is so late (ticks) comes with the next one."""
AT_ONCE = [
    said
    for said in TABLE
    if said.board == "cobs"
    and not said.inactive
    and re.search("stage|fired|FAULT|version|anew", said.words)
]


@pytest.mark.parametrize("said", AT_ONCE, ids=lambda s: f"{s.field}: {s.value}")
def test_the_older_one_alone_says_it(said: Said, monkeypatch: pytest.MonkeyPatch):
    with on_motors("cobs", monkeypatch) as (device, wire):
        for tick in range(BEFORE + 4):
            once = tick == BEFORE
            wire.now = replace(SOUND, spoil=said.spoil, late=TOGETHER) if once else SOUND
            device.read(tick)
            device.write(tick, (0.0, 0.0))
            if tick == BEFORE:
                assert device.state is State.ACTIVE, device.fault_sentence()
            wire.tick()
        assert device.state is State.FAULT
        assert re.search(said.words, device.fault_sentence()), device.fault_sentence()


def test_a_switch_that_was_open_in_the_older_one_was_let_go_of(monkeypatch: pytest.MonkeyPatch):
    held, opened = cobs(status=lambda s: s | INPUT), cobs(status=lambda s: s & ~INPUT)
    told: list[bool] = []
    with on_motors("cobs", monkeypatch) as (device, wire):
        for tick in range(BEFORE + 6):
            once = tick == BEFORE
            wire.now = replace(SOUND, spoil=opened if once else held, late=TOGETHER if once else 0)
            device.read(tick)
            told.append(device.input_held)
            device.write(tick, (0.0, 0.0))
            wire.tick()
    assert told[1:] == [tick != BEFORE + 2 for tick in range(1, BEFORE + 6)]


def test_what_is_measured_is_the_newest_one(monkeypatch: pytest.MonkeyPatch):
    ages: list[int] = []
    with on_motors("cobs", monkeypatch) as (device, wire):
        for tick in range(BEFORE):
            wire.now = replace(SOUND, late=TOGETHER if tick == BEFORE - 10 else 0)
            ages.append(device.read(tick).sample_age)
            device.write(tick, (0.0, 0.0))
            wire.tick()
        assert device.state is State.ACTIVE, device.fault_sentence()
    assert ages[1:] == [int(tick == BEFORE - 9) for tick in range(1, BEFORE)]


HALVES = {
    "cia402: fault": (without(0x182), can(0x181, packed("<H", 0, 8)), "drive 1 is in .*'fault'"),
    "cia402: off": (without(0x181), can(0x182, packed("<H", 0, 0x40)), "output stage is off"),
    "odrive: speed": (without(0x009), can(0x029, packed("<f", 4, 50.0)), "axis 1 says that it tur"),
}


@pytest.mark.parametrize("name", HALVES)
def test_what_one_node_says_counts_though_the_other_is_silent(
    name: str, monkeypatch: pytest.MonkeyPatch
):
    silent, odd, words = HALVES[name]
    with on_motors(name.partition(":")[0], monkeypatch) as (device, wire):
        for tick in range(BEFORE + 4):
            spoil: Spoil | None = (lambda answer: odd(silent(answer))) if tick >= BEFORE else None
            wire.now = replace(SOUND, spoil=spoil)
            device.read(tick)
            device.write(tick, (0.0, 0.0))
            wire.tick()
        assert device.state is State.FAULT
        assert re.search(words, device.fault_sentence()), device.fault_sentence()
