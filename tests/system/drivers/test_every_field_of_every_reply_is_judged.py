"""A reply that is whole, and in which one field says what cannot be: FAULT, or a reason why not."""

from __future__ import annotations

import re
from dataclasses import fields, replace

import pytest

from hil.device.contract import State
from hil.drivers.canopen.protocol import Emergency, SdoAnswer
from hil.drivers.cobs.protocol import Reply, ReplyFlag
from tests.support.hil.motor_wire import SOUND, on_motors
from tests.support.hil.motors.boards import BOARDS
from tests.support.hil.reply_table import TABLE, Said

BEFORE, AFTER = 150, 120
PUSH = (0.09, -0.09)


@pytest.mark.parametrize("said", TABLE, ids=lambda s: f"{s.board}: {s.field}: {s.value}")
def test_what_the_device_makes_of_it(said: Said, monkeypatch: pytest.MonkeyPatch):
    with on_motors(said.board, monkeypatch) as (device, wire):
        if said.inactive:
            device.deactivate()
        for tick in range(BEFORE + AFTER):
            wire.now = replace(SOUND, spoil=said.spoil) if tick >= BEFORE else SOUND
            device.read(tick)
            share = min(1.0, (tick + 1) / BEFORE)
            device.write(tick, (share * PUSH[0], share * PUSH[1]))
            if tick == BEFORE - 1:
                wanted = State.INACTIVE if said.inactive else State.ACTIVE
                assert device.state is wanted, device.fault_sentence()
            wire.tick()
        if said.words:
            assert device.state is State.FAULT
            assert re.search(said.words, device.fault_sentence()), device.fault_sentence()
        else:
            assert said.why
            assert device.state is wanted, device.fault_sentence()
            assert device.age <= 1


def named(board: str) -> str:
    return " ".join(said.field for said in TABLE if said.board == board)


def test_the_table_has_every_board_and_every_field_that_is_decoded():
    assert {said.board for said in TABLE} == set(BOARDS)
    assert all(field.name in named("cobs") for field in fields(Reply))
    assert all(flag.name in named("cobs") for flag in ReplyFlag)
    for kind, word in ((Emergency, "emergency"), (SdoAnswer, "SDO")):
        for field in fields(kind):
            assert re.search(rf"{word}[\w, ]* {field.name}", named("canopen")), field.name
