"""A bus that takes one drive's torque and not the other's: the record has what is on the wire."""

from __future__ import annotations

import pytest

from hil.device.contract import State
from hil.device.errors import DeviceGone
from tests.support.hil.motor_wire import MotorPort, on_motors

TICKS = 200
PUSH = (0.008, -0.008)


@pytest.mark.parametrize(
    ("board", "second"), [("odrive", 1 << 5 | 0x0E), ("cia402", 0x202)], ids=["odrive", "cia402"]
)
def test_each_joint_has_its_own(board: str, second: int, monkeypatch: pytest.MonkeyPatch):
    with on_motors(board, monkeypatch) as (device, wire):
        send, broken = MotorPort.send, False

        def refuses(self: MotorPort, identifier: int, data: bytes, *, remote: bool) -> None:
            if broken and identifier == second:
                raise DeviceGone("takes no more frames")
            send(self, identifier, data, remote=remote)

        monkeypatch.setattr(MotorPort, "send", refuses)
        for tick in range(TICKS):
            device.read(tick)
            before = device.write(tick, PUSH).torque
            wire.tick()
        device.read(TICKS)
        broken = True
        sent = device.write(TICKS, (0.0, 0.0))
        assert before[0] > 0.0 > before[1]
        assert sent.torque == (0.0, before[1]), "the first joint's zero is on the wire"
        assert wire.on_wire == pytest.approx(sent.torque, abs=1e-7)
        assert device.state is State.FAULT
        broken = False
        monkeypatch.setattr(MotorPort, "send", send)
