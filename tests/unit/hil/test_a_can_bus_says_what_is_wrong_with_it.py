"""Error frames, a full queue and frames that nobody acknowledges are named in the sentence."""

from __future__ import annotations

import errno
import socket
import struct
from typing import Any

import pytest

from hil.device.errors import DeviceGone
from hil.wire.can_bus import QUEUE_TICKS, CanBus
from hil.wire.can_port import CanFrame, FrameKind
from hil.wire.socketcan import SocketCanPort

FRAME = struct.Struct("=IB3x8s")
CONFIRM = 0x800


class Wire:
    """A CAN socket without a kernel that has any: what the socket calls give is written here."""

    def __init__(self) -> None:
        self.sent: list[bytes] = []
        self.inbox: list[tuple[bytes, int]] = []
        self.refuses: OSError | None = None
        self._some = socket.socketpair()

    def setblocking(self, _: bool) -> None: ...

    def fileno(self) -> int:
        return self._some[0].fileno()

    def send(self, frame: bytes) -> int:
        if self.refuses is not None:
            raise self.refuses
        self.sent.append(frame)
        return len(frame)

    def recvmsg(self, size: int) -> tuple[bytes, list[Any], int, Any]:
        assert size == FRAME.size
        if not self.inbox:
            raise BlockingIOError
        frame, flags = self.inbox.pop(0)
        return frame, [], flags, None

    def close(self) -> None:
        for end in self._some:
            end.close()

    def confirm(self) -> None:
        """All that was sent was on the bus."""
        self.inbox += [(frame, CONFIRM) for frame in self.sent]
        self.sent.clear()

    def brings(self, word: int, data: bytes) -> None:
        self.inbox.append((FRAME.pack(word, len(data), data), 0))


@pytest.fixture
def wire():
    made = Wire()
    yield made
    made.close()


def bus_on(wire: Wire) -> CanBus:
    return CanBus(
        name="socketcan://can0",
        port=SocketCanPort("can0", made=wire),
        key=("socketcan", "can0"),
        bitrate=1e6,
        budget=0.0,
    )


def test_a_frame_is_16_bytes_both_ways(wire: Wire):
    port = SocketCanPort("can0", made=wire)
    port.send(0x201, b"\1\2\3", remote=False)
    assert wire.sent == [bytes.fromhex("01020000 03000000 0102030000000000")]
    wire.brings(0x181, b"\7\7")
    assert port.receive(0.0) == CanFrame(0x181, b"\7\7")
    wire.brings(0x80000000 | 0x12345, b"")
    found = port.receive(0.0)
    assert found is not None
    assert found.kind is FrameKind.OTHER
    assert port.receive(0.0) is None


@pytest.mark.parametrize(
    ("word", "data", "words"),
    [
        (0x20000000 | 0x20, bytes(8), "nobody acknowledges"),
        (0x20000000 | 0x04, b"\0\x20" + bytes(6), "error-passive"),
        (0x20000000 | 0x04, b"\0\x08" + bytes(6), "warns"),
        (0x20000000 | 0x100, bytes(8), "restarted"),
        (0x20000000 | 0x08, bytes(8), "class 0x8"),
    ],
)
def test_an_error_frame_is_remembered_until_a_frame_comes(wire: Wire, word, data, words):
    bus = bus_on(wire)
    wire.brings(word, data)
    bus.collect("device")
    assert words in (bus.complaint or "")
    wire.brings(0x181, b"\0")
    bus.collect("device")
    assert bus.complaint is None


def test_bus_off_is_a_bus_that_is_gone_for_every_device(wire: Wire):
    bus = bus_on(wire)
    wire.brings(0x20000000 | 0x40, bytes(8))
    for device in ("first", "second", "first"):
        with pytest.raises(DeviceGone, match="bus-off"):
            bus.collect(device)


def test_a_full_queue_is_a_sentence(wire: Wire):
    bus = bus_on(wire)
    wire.refuses = OSError(errno.ENOBUFS, "No buffer space available")
    with pytest.raises(DeviceGone, match="queue is full"):
        bus.send(0x201, b"\0\0")


def test_a_torque_that_waits_for_somebody_to_acknowledge_it_ends_the_run(wire: Wire):
    bus = bus_on(wire)
    for _ in range(3 * QUEUE_TICKS):
        bus.send(0x201, b"\1\0")
        wire.confirm()
        bus.collect("device")
    for tick in range(QUEUE_TICKS + 2):
        bus.send(0x201, b"\1\0")
        if tick <= QUEUE_TICKS - 1:
            bus.collect("device")
            continue
        with pytest.raises(DeviceGone, match="nobody acknowledges"):
            bus.collect("device")
        return
    pytest.fail("the queue grew without end")


def test_a_wait_for_a_silent_node_is_as_long_as_it_was_told(wire: Wire, monkeypatch):
    """poll(2) would make a whole millisecond of it, and all devices have 600 us in a tick."""
    asked: list[float] = []

    def looks(*given: Any) -> tuple[list[int], list[int], list[int]]:
        asked.append(given[3])
        return [], [], []

    monkeypatch.setattr("hil.wire.socketcan.select.select", looks)
    monkeypatch.setattr("hil.wire.socketcan.select.poll", None)
    assert SocketCanPort("can0", made=wire).receive(300e-6) is None
    assert asked == [300e-6]
