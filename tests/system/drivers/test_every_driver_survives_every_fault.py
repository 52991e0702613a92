"""Every driver and every fault, in lock-step: what happens, after how many ticks, is written down.

test_the_safety_page_says_what_was_seen compares it with the table in docs/safety.md.
"""

from __future__ import annotations

import pytest

from hil.device.contract import ZERO, Flag, State, WriteOutcome
from hil.safety.limits import TickLimits
from tests.support.hil import fault_table
from tests.support.hil.driver_bench import DRIVERS, Bench

TICKS = 120
LONGEST = {"runaway": 200, "latched": 200}

FAULTS = {
    "one answer lost": ("drop", {"ticks": 1}),
    "answers lost for 5 ticks": ("drop", {"ticks": 5}),
    "answers lost for good": ("drop", {}),
    "one byte (frame) to the device lost": ("drop-command", {"ticks": 1}),
    "a bit of an answer flipped": ("corrupt", {"ticks": 1, "bit": 0}),
    "a bit of a command flipped": ("corrupt-command", {"ticks": 1, "bit": 0}),
    "answers 1 tick late": ("delay", {"ticks": 40, "delay": 1}),
    "answers 5 ticks late": ("delay", {"ticks": 40, "delay": 5}),
    "board hangs": ("hang", {}),
    "unplugged": ("unplug", {}),
    "motors run away": ("runaway", {}),
    "torque latched": ("latched", {}),
}
UNNOTICED = {"one answer lost", "answers 1 tick late", "torque latched", "answers lost for 5 ticks"}
CHECKED = UNNOTICED | {
    "one byte (frame) to the device lost",
    "a bit of an answer flipped",
    "a bit of a command flipped",
}
"""A checksum throws spoiled frames away, and the next tick brings new ones."""
UNNUMBERED = CHECKED | {"answers 5 ticks late"}
"""Cyclic frames on a bus do not say how old they are."""
MAY_GO_ON = {"haply": UNNOTICED, "cobs": CHECKED, "cobs (C firmware)": CHECKED}


def words(rig, ticks_to_fault: int | None, oldest: int) -> str:
    device = rig.device
    if ticks_to_fault is None:
        return f"goes on, data at most {oldest} ticks old" if oldest else "not noticed"
    assert device.fault is not None
    zeroed = ticks_to_fault + device.outcome_ticks
    outcome = {
        WriteOutcome.ZERO_CONFIRMED: f"zero confirmed in {zeroed} ticks",
        WriteOutcome.WATCHDOG: "device watchdog",
        WriteOutcome.UNKNOWN: "**output unknown**, cut the power",
    }[device.outcome]
    return f"fault ({device.fault.cause}) in {ticks_to_fault} ticks; {outcome}"


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("name", DRIVERS)
def test_outcome(name: str, fault: str, bench: Bench):
    rig = bench.rig(name, hand={"stiffness": 20.0, "damping": 0.3})
    rig.exchange(500, (0.01, -0.01))
    assert rig.device.state is State.ACTIVE, rig.device.fault_sentence()
    kind, values = FAULTS[fault]
    rig.fault(kind, **values)
    faulted, oldest, last = None, 0, rig.device.sent
    for passed in range(LONGEST.get(kind, TICKS)):
        (exchanged,) = rig.exchange(1, (0.01, -0.01))
        oldest = max(oldest, exchanged[0].sample_age)
        if rig.device.state is State.FAULT:
            faulted = passed if faulted is None else faulted
            sent = exchanged[1]
            zeroed = sent.torque == ZERO or sent.flags & (Flag.NOT_SENT | Flag.ZEROING)
            assert zeroed, "zero in the very tick"
            assert all(abs(now) <= abs(was) for now, was in zip(sent.torque, last, strict=True))
        last = exchanged[1].torque
    device = rig.device
    if faulted is None:
        assert fault in MAY_GO_ON.get(name, UNNUMBERED), "this fault has to be noticed"
        assert oldest <= TickLimits.at(1 / 1024).drop
    else:
        assert device.settled
        truth = rig.truth()
        if device.outcome is WriteOutcome.ZERO_CONFIRMED:
            assert truth["torque"] == [0.0, 0.0], "confirmed has to mean true"
        if device.outcome is WriteOutcome.WATCHDOG:
            rig.emulator.control.ask("advance", ticks=40)
            assert rig.truth()["torque"] == [0.0, 0.0]
        if device.outcome is WriteOutcome.UNKNOWN:
            assert "cut the power" in device.fault_sentence()
        rig.exchange(20, (0.01, -0.01))
        assert device.state is State.FAULT, "latched"
    fault_table.note(name, fault, words(rig, faulted, oldest))
