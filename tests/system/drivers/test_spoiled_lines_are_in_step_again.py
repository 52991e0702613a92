"""After a spoiled stretch: the framed protocol and slcan read the second frame at the latest.

Haply's protocol cannot be in step again by itself, so there the driver faults; what it could not
notice is over within one frame.
"""

from __future__ import annotations

import contextlib
import os
import random
import tty

import pytest
from can import CanError, CanOperationError, Message
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.device.contract import ZERO, Flag, State, WriteOutcome
from hil.drivers.cobs import protocol as cobs
from hil.drivers.haply.driver import OUTSTANDING_TICKS
from hil.drivers.haply.emulator import SATURATION
from hil.wire import cobs_frames
from hil.wire import slcan_lines as slcan
from hil.wire.slcan import StrictSlcanBus
from tests.fuzz.wire import on_wire

LINES = [f"t{0x029 + n:03x}8{n:016x}\r".encode() for n in range(4)]
FRAMES = [cobs.command(cobs.CommandFlag.ENABLE, n, (0.01 * n, -0.02), 20) for n in range(4)]
PUSH = (0.01, -0.01)


def spoilings(whole: bytes, inserted=range(256)):
    """Every stretch lost, every bit flipped, and bytes inserted at every place: (how, result)."""
    for place in range(len(whole)):
        for end in range(place + 1, len(whole) + 1):
            yield f"bytes {place} to {end} lost", whole[:place] + whole[end:]
        for bit in range(8):
            flipped = bytes((whole[place] ^ 1 << bit,))
            yield f"bit {bit} of byte {place}", whole[:place] + flipped + whole[place + 1 :]
        for byte in inserted:
            yield f"{byte} before byte {place}", whole[:place] + bytes((byte,)) + whole[place:]


@pytest.mark.parametrize(
    ("frames", "splitter", "read"),
    [
        (FRAMES, cobs_frames.Splitter, lambda frame: cobs_frames.payload(frame[:-1])),
        (LINES, slcan.LineSplitter, lambda line: slcan.data_frame(line[:-1])),
    ],
    ids=["cobs", "slcan"],
)
def test_the_second_frame_after_a_spoiled_one_is_read(frames, splitter, read):
    first, spoiled, *after = frames
    late = 0
    for how, stretch in spoilings(spoiled):
        reader = splitter()
        reader.feed(first)
        reader.feed(stretch)
        found = [reader.feed(frame) for frame in after]
        assert found[1] == [read(after[1])], how
        late += found[0] != [read(after[0])]
    assert late > 0, "one frame more may be lost: its beginning is the end of the spoiled one"


@settings(deadline=None, derandomize=True)
@given(st.binary(max_size=300), st.lists(st.integers(1, 30), max_size=20))
def test_slcan_is_in_step_again_after_any_bytes_however_they_come_in(noise, sizes):
    reader, text, found = slcan.LineSplitter(), noise + LINES[0] + LINES[1], []
    for size in sizes:
        found += reader.feed(text[:size])
        text = text[size:]
    found += reader.feed(text)
    assert found[-1] == slcan.data_frame(LINES[1][:-1])


def test_an_slcan_line_counts_with_its_exact_length_only():
    """What is cut, lengthened, or not in hexadecimal digits is left out; digits cannot be told."""
    line = LINES[1][:-1]
    right = slcan.data_frame(line)
    digits = set(b"0123456789abcdefABCDEF")
    for how, spoiled in spoilings(line):
        if slcan.data_frame(spoiled) not in {None, right}:
            assert len(spoiled) == len(line), how
            assert set(spoiled[1:]) <= digits, how


def test_bytes_that_are_no_text_do_not_stop_the_bus():
    """On a real pseudo-terminal; python-can's own reader keeps such bytes and fails for ever."""
    master, slave = os.openpty()
    tty.setraw(master)
    bus = StrictSlcanBus(os.ttyname(slave), sleep_after_open=0.0)
    try:
        numbers = random.Random(2)
        for number in range(50):
            os.write(master, numbers.randbytes(40) + LINES[0] + f"t0298{number:016x}\r".encode())
            found = None
            while (message := bus.recv(1.0 if found is None else 0.0)) is not None:
                found = bytes(message.data)
                if found == number.to_bytes(8, "big"):
                    break
            assert found == number.to_bytes(8, "big")
        assert bus.recv(0.0) is None
    finally:
        bus.shutdown()
        os.close(master)
        os.close(slave)


def test_an_adapter_that_takes_no_more_is_an_error_and_no_wait():
    """A loop that waited for it would be killed with its torque still out."""
    master, slave = os.openpty()
    tty.setraw(master)
    bus = StrictSlcanBus(os.ttyname(slave), sleep_after_open=0.0)
    frame = Message(arbitration_id=0x201, data=bytes(8), is_extended_id=False)

    def fill() -> None:
        for _ in range(100_000):
            bus.send(frame)

    with pytest.raises(CanOperationError, match="takes no more"):
        fill()
    with contextlib.suppress(CanOperationError):
        bus.shutdown()
    os.close(master)
    os.close(slave)


def test_a_lost_adapter_is_an_error():
    master, slave = os.openpty()
    tty.setraw(master)
    bus = StrictSlcanBus(os.ttyname(slave), sleep_after_open=0.0)
    os.close(master)
    with pytest.raises((OSError, CanError)):
        bus.recv(0.5)
    with contextlib.suppress(OSError, CanError):
        bus.shutdown()
    os.close(slave)


def exchanged(ticks: int, to_board=None, to_host=None, at: int = 5):
    """A Haply at work whose line spoils one frame: (device, tick of its fault, board's torques)."""
    device, wire = on_wire("haply")
    faulted, torques, commanded = None, [], []
    for tick in range(ticks):
        wire.to_board = to_board if to_board and tick == at else bytes
        wire.to_host = to_host if to_host and tick == at else bytes
        device.read(tick)
        sent = device.write(tick, PUSH)
        commanded.append(sent.torque)
        torques.append(wire.board.world.torque)
        if device.state is State.FAULT:
            faulted = tick if faulted is None else faulted
            assert sent.torque == ZERO or sent.flags & (Flag.NOT_SENT | Flag.ZEROING)
    return device, faulted, torques, commanded


FRAME, REPLY = 10, 9


@pytest.mark.parametrize("way", ["command", "answer"])
def test_a_haply_out_of_step_faults_and_its_board_ends_at_zero(way):
    """Every lost stretch, every flipped bit, and inserted bytes, in one frame of either way."""
    at, size = 5, FRAME if way == "command" else REPLY
    outcomes = {"zero": 0, "one frame": 0, "unknown": 0}
    length = len(list(spoilings(bytes(size), inserted=(0, 1, 2, 5, 0x3C, 0xFF))))
    for number in range(length):

        def spoil(whole: bytes, number: int = number) -> bytes:
            return [s for _, s in spoilings(whole, inserted=(0, 1, 2, 5, 0x3C, 0xFF))][number]

        device, faulted, torques, commanded = exchanged(
            at + 40, **{"to_board" if way == "command" else "to_host": spoil}, at=at
        )
        assert max(abs(value) for pair in torques for value in pair) <= SATURATION
        if faulted is None:
            # Nothing in the bytes could show it; the very next frame is right again.
            outcomes["one frame"] += 1
            assert torques[at + 1 :] == commanded[at + 1 :]
            assert device.state is State.ACTIVE
            continue
        assert faulted <= at + OUTSTANDING_TICKS + 1
        assert device.state is State.FAULT
        if device.outcome is WriteOutcome.UNKNOWN:
            outcomes["unknown"] += 1
            assert "cut the power" in device.fault_sentence()
            continue
        outcomes["zero"] += 1
        assert torques[-1] == ZERO, "confirmed has to mean true"
        wrong = [torque not in {ZERO, *commanded} for torque in torques]
        assert sum(wrong) <= 2, "a torque that nobody commanded lasts two ticks at most"
    assert outcomes["zero"] > 60
    assert outcomes["one frame"] > 30
    assert outcomes["unknown"] <= 0.15 * length, "angles that jump, and a byte that begins a setup"
