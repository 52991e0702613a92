"""``applied_torque`` is at every tick what was last put on the wire, whatever goes wrong.

Read by motors that were written apart from drivers and emulators, one pair at the host's end of the
wire, one that gets what the faults leave. When a device is brought to zero, the torque before it
stays in the record until an answer confirms zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from math import inf, nan

import pytest

from hil.device.contract import ZERO, Flag, Sent, State, WriteOutcome
from hil.device.device import Device
from hil.device.fault_latch import SETTLE_TICKS
from hil.safety.permission import dead_man
from tests.support.hil.motor_wire import SOUND, MotorWire, Pair, WireFault, on_motors
from tests.support.hil.motors.boards import BOARDS as MOTORS

PIPELINED = ("canopen, pipelined", "cia402, pipelined")
BOARDS = (*MOTORS, *PIPELINED)
BEFORE, AFTER = 150, 100
"""Ticks of a growing torque before the fault, and from it to the end."""
PUSH = (0.02, -0.01)
ROUNDED = {"cia402": 0.2e-3}
"""A torque (N.m) of which the wire has whole multiples alone: growth is rounded, too."""
AT = BEFORE
"""The tick of the fault."""


@dataclass(frozen=True)
class Case:
    """What goes wrong, for how many ticks."""

    fault: WireFault = SOUND
    ticks: float = inf
    does: Callable[[Device, MotorWire], None] | None = None
    """What happens besides, once."""
    command: Pair | None = None
    """What is commanded at that tick."""
    faults: frozenset[str] = frozenset(BOARDS)
    """The boards whose device has to go into FAULT."""
    may: frozenset[str] = frozenset()
    """The boards whose device may as well."""


def released(device: Device, wire: MotorWire) -> None:
    del wire
    held = iter([True])
    device.permission = dead_man(device.name, lambda: next(held, False), device.permission)


def alarmed(device: Device, wire: MotorWire) -> None:
    del wire
    device._life.alarm.raise_for("the other")


SYNCHRONOUS = frozenset({"canopen", "cia402"})
HAPLY, NOBODY, EVERYBODY = frozenset({"haply"}), frozenset[str](), frozenset(BOARDS)
CASES = {
    "nothing": Case(faults=NOBODY),
    "one answer lost": Case(WireFault(lose_answers=True), 1, faults=HAPLY),
    "answers lost for 5 ticks": Case(WireFault(lose_answers=True), 5, faults=HAPLY),
    "answers lost for good": Case(WireFault(lose_answers=True)),
    "a byte (frame) to the board lost": Case(WireFault(lose_command=True), 1, faults=HAPLY),
    "a bit of an answer flipped": Case(WireFault(flip_answer=True), 1, faults=HAPLY),
    "a bit of a command flipped": Case(WireFault(flip_command=True), 1, faults=HAPLY),
    # Nothing tells that they answer an earlier SYNC, so on CANopen they are no answers; pipelined
    # they are taken for new ones.
    "answers 1 tick late": Case(WireFault(late=1), 20, faults=SYNCHRONOUS),
    "answers 5 ticks late": Case(
        WireFault(late=5),
        20,
        faults=HAPLY | {"cobs"} | SYNCHRONOUS,
        may=frozenset({"odrive", *PIPELINED}),
    ),
    "board hangs": Case(WireFault(hang=True)),
    "unplugged": Case(WireFault(gone=True)),
    "board restarts": Case(does=lambda _, wire: wire.restart()),
    "dead man released": Case(does=released),
    "another device in FAULT": Case(
        does=lambda device, _: device._life.alarm.raise_for("the other")
    ),
    "command is no number": Case(command=(nan, 0.0)),
    "command leaps": Case(command=(9.0, -9.0), faults=NOBODY),
}


@dataclass
class Seen:
    """One tick."""

    state: State
    sent: Sent
    on_wire: Pair
    told: Pair


def driven(device: Device, wire: MotorWire, case: Case) -> list[Seen]:
    """What was seen at every tick."""
    found: list[Seen] = []
    for tick in range(BEFORE + AFTER):
        wire.now = case.fault if AT <= tick < AT + case.ticks else SOUND
        if tick == AT and case.does is not None:
            case.does(device, wire)
        device.read(tick)
        share = min(1.0, (tick + 1) / BEFORE)
        now = (share * PUSH[0], share * PUSH[1])
        if tick == AT and case.command is not None:
            now = case.command
        sent = device.write(tick, now)
        found.append(Seen(device.state, sent, wire.on_wire, wire.told))
        wire.tick()
    return found


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("board", BOARDS)
def test_at_every_tick(board: str, name: str, monkeypatch: pytest.MonkeyPatch):
    case = CASES[name]
    with on_motors(board, monkeypatch) as (device, wire):
        seen = driven(device, wire, case)
    assert seen[AT - 1].state is State.ACTIVE, device.fault_sentence()
    assert near(seen[AT - 1].told, seen[AT - 1].on_wire)
    assert min(abs(torque) for torque in seen[AT - 1].on_wire) > 0.0, "it pushes by then"
    before = ZERO
    for each in seen:
        at_zero = each.state is State.FAULT and each.sent.torque == ZERO
        if not (at_zero or near(each.sent.torque, each.on_wire)):
            # Zero is on the wire, and the record waits for the answer.
            assert each.state is State.FAULT
            assert each.on_wire == ZERO
            assert each.sent.flags & Flag.ZEROING
            assert each.sent.torque == before, "what is not confirmed is held"
        if at_zero:
            assert each.told == ZERO, "a zero in the record has to be one at the motors"
        before = each.sent.torque
    bounded(device, seen)
    faulted = [tick for tick, each in enumerate(seen) if each.state is State.FAULT]
    if board not in case.may:
        assert bool(faulted) is (board in case.faults), device.fault_sentence()
    if faulted:
        confirmed = device.outcome is WriteOutcome.ZERO_CONFIRMED
        assert (seen[-1].sent.torque == ZERO) is confirmed
        if case.ticks < inf or case.does or case.command:
            assert confirmed, "a board that answers again is seen at zero"
            last = faulted[0] + SETTLE_TICKS
            assert seen[last].sent.torque == ZERO


def bounded(device: Device, seen: list[Seen]) -> None:
    """At every tick no torque on the wire is above its limit, and none grows faster than its slew;
    from the tick of the fault on none grows at all."""
    limits = device.file.limits
    for one, next_ in pairwise(seen):
        for was, now in zip(one.on_wire, next_.on_wire, strict=True):
            assert abs(now) <= limits.torque + 1e-9
            grows = abs(now) - abs(was)
            step = limits.slew / 1024 + ROUNDED.get(device.driver.driver, 0.0)
            assert grows <= (0.0 if next_.state is State.FAULT else step) + 1e-9


def near(one: Pair, other: Pair) -> bool:
    return all(abs(a - b) < 1e-7 for a, b in zip(one, other, strict=True))
