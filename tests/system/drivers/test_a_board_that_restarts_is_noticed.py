"""A brown-out of a board with absolute counts: nothing in its angles shows it, its clock does."""

from __future__ import annotations

from hil.device.contract import ZERO, State
from hil.device.errors import Cause
from tests.support.hil.driver_bench import Bench, Rig

PUSH = (0.01, -0.01)


def test_it_ends_at_zero_and_un_homed(bench: Bench):
    rig: Rig = bench.rig("cobs")
    rig.exchange(1200, PUSH)
    assert rig.device.state is State.ACTIVE, rig.device.fault_sentence()
    rig.fault("restart", start=1, ticks=1)
    for _ in range(4):
        ((_, sent),) = rig.exchange(1, PUSH)
    assert rig.device.state is State.FAULT
    assert rig.device.fault is not None
    assert rig.device.fault.cause is Cause.RESTARTED
    assert not rig.device.homed
    assert sent.torque == ZERO
    rig.exchange(5, PUSH)
    assert rig.truth()["torque"] == [0.0, 0.0]
