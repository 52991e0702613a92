"""Serial protocols: the framed one of home-made boards, Haply's, and slcan's lines."""

from __future__ import annotations

import functools
import struct
from math import isfinite

from hil.device.contract import ZERO, Flag, State
from hil.device.errors import ProtocolError
from hil.drivers.cobs import protocol as cobs
from hil.drivers.cobs.emulator import CobsBoard, FirmwareBoard
from hil.drivers.haply import protocol as haply
from hil.drivers.haply.emulator import SATURATION, HaplyBoard
from hil.emulation.board import BoardFrame
from hil.emulation.links import parse_slcan
from hil.emulation.world import World
from hil.firmware.build import build
from hil.wire import cobs_frames
from hil.wire import slcan_lines as slcan
from tests.fuzz import oracle
from tests.fuzz.script import Script, spoil
from tests.fuzz.wire import Rest, on_wire
from tests.support.scratch import scratch_folder

PUSH = (0.01, -0.01)
LONGEST = cobs_frames.LONGEST_FRAME


def cobs_stream(data: bytes) -> None:
    """Nothing without a right checksum is accepted, however the bytes come in."""
    script = Script(data)
    frames = [
        cobs_frames.frame(struct.pack("<BBHIiiH", cobs.REPLY, 1, n, 976 * n, 40 * n, -n, n % 9))
        for n in range(script.number(6))
    ]
    stream = spoil(b"".join(frames), script) + script.take(script.number(100))
    splitter, found, left = cobs_frames.Splitter(), [], stream
    while left:
        size = 1 + script.number(40)
        found += splitter.feed(left[:size])
        left = left[size:]
    right = oracle.payloads(stream)
    if all(len(piece) <= LONGEST for piece in stream.split(b"\0")):
        assert found == right, "the independent reader reads something else"
    for body in found:
        assert oracle.crc16(body) == cobs_frames.crc(body)
        _is_reply_of_its_form(body)
    clean = [cobs_frames.frame(struct.pack("<BBHIiiH", 0x81, 1, n, n, n, n, 0)) for n in (1, 2)]
    after = [body for each in clean for body in splitter.feed(each)]
    assert after[-1:] == oracle.payloads(clean[1]), "in step again at the second frame"


def _is_reply_of_its_form(body: bytes) -> None:
    """What is taken for a reply is one; of its form, and from no board of ours, is an error."""
    of_its_form = len(body) == 18 and body[0] == cobs.REPLY
    try:
        answer = cobs.reply(body)
    except ProtocolError:
        assert of_its_form
        assert body[1] >= 1 << len(cobs.ReplyFlag) or any(body[16:])
        return
    assert answer is None or of_its_form


def cobs_boards(data: bytes) -> None:
    """The two device sides agree about everything that comes, and noise is no torque."""
    python = CobsBoard(World(Rest((1.0, 2.0)), lockstep=False))
    c = FirmwareBoard(World(Rest((1.0, 2.0)), lockstep=False), firmware=_firmware())
    script = Script(data)
    frames = b""
    for number in range(script.number(4)):
        raw = struct.unpack("<ff", script.take(8).ljust(8, b"\0"))
        flags = cobs.CommandFlag(script.number(4))
        frames += cobs.command(flags, number, raw, script.number(65536))
    stream = spoil(frames, script) + script.rest()
    before = stream.split(b"\0")
    if any(len(piece) >= LONGEST for piece in before):
        return  # what is too long is noise to both; how much of its end they keep differs
    answers = [board.receive(stream) for board in (python, c)]
    joined = [b"".join(part for part in answer if isinstance(part, bytes)) for answer in answers]
    assert python.world.torque == c.world.torque
    assert all(isfinite(torque) for torque in c.world.torque)
    assert [body[:4] for body in oracle.payloads(joined[0])] == [
        body[:4] for body in oracle.payloads(joined[1])
    ]
    commands = [body for body in oracle.payloads(stream) if len(body) == 14 and body[0] == 1]
    if not commands:
        assert c.world.torque == ZERO


@functools.cache
def _firmware() -> str:
    return str(build(scratch_folder("fuzz")))


def cobs_driver(data: bytes) -> None:
    """A spoiled line never gives the driver a wrong angle, nor the board a wrong torque."""
    script = Script(data)
    device, wire = on_wire("cobs")
    home, commanded = device.file.home, {ZERO}
    assert home is not None
    for tick in range(24):
        spoiling = tick < 12
        wire.to_board = wire.to_host = (lambda b: spoil(b, script, 2)) if spoiling else bytes
        measured = device.read(tick)
        assert _near(measured.joint_angle, home, device.file.quantum)
        commanded.add(device.write(tick, PUSH).torque)
        assert wire.board.world.torque in commanded, "a torque that nobody commanded"
    if device.state is State.ACTIVE:
        assert device.read(24).sample_age == 0, "in step again"


def haply_reply(data: bytes) -> None:
    """Any nine bytes are two angles or a protocol error."""
    axes = [haply.HaplyAxis(port=2), haply.HaplyAxis(port=1)]
    try:
        first, second = haply.angles(5, axes, data)
    except ProtocolError:
        return
    assert len(data) == haply.REPLY_BYTES
    assert data[0] == 5
    assert struct.pack("<ff", second, first) == data[1:]
    assert max(abs(first), abs(second)) < haply.LARGEST_DEGREES


def haply_board(data: bytes) -> None:
    """A board takes every byte that comes; its motors stay within their saturation."""
    script = Script(data)
    board = HaplyBoard(World(Rest((1.0, 2.0)), lockstep=False))
    axes = [haply.HaplyAxis(port=2), haply.HaplyAxis(port=1)]
    if script.number(2):
        board.receive(haply.reset(5) + haply.setup(5, axes))
    while script.left:
        board.receive(script.take(1 + script.number(16)))
        assert all(abs(torque) <= SATURATION for torque in board.world.torque)


def haply_driver(data: bytes) -> None:
    """However the line is spoiled: a fault stays one and commands zero; no fault means in step."""
    script = Script(data)
    device, wire = on_wire("haply")
    sent = None
    for tick in range(30):
        spoiling = tick < 12
        wire.to_board = wire.to_host = (lambda b: spoil(b, script, 1)) if spoiling else bytes
        if spoiling and script.number(8) == 1:
            wire.put(script.take(script.number(12)))
        device.read(tick)
        faulted = device.state is State.FAULT
        sent = device.write(tick, PUSH)
        assert not faulted or device.state is State.FAULT
        assert not faulted or sent.torque == ZERO or sent.flags & (Flag.NOT_SENT | Flag.ZEROING)
    if device.state is State.ACTIVE:
        assert sent is not None
        assert wire.board.world.torque != ZERO
        assert _near(wire.board.world.torque, sent.torque, 1e-9)


def slcan_lines(data: bytes) -> None:
    """A line that both sides read is the line that a frame is written as, to the last digit."""
    splitter, frames = slcan.LineSplitter(), []
    script = Script(data)
    while script.left:
        frames += splitter.feed(script.take(1 + script.number(30)))
    text = bytes(data)
    for line in text.replace(b"\a", b"\r").split(b"\r"):
        host, board = slcan.data_frame(line), parse_slcan(line)
        if board is not None and not board.remote:
            assert host == (board.identifier, board.data)
        if host is not None:
            assert board == BoardFrame(*host)
            assert f"t{host[0]:03x}{len(host[1])}{host[1].hex()}".encode() == line.lower()
    splitter.feed(b"t0098000000000000")
    after = splitter.feed(b"0000\r") + splitter.feed(b"t0112BEEF\rt0212CAFE\r")
    assert after[-1] == (0x021, b"\xca\xfe"), "in step again at the second frame"


def _near(value: tuple[float, float], wanted: tuple[float, float], by: float) -> bool:
    return all(abs(a - b) <= by for a, b in zip(value, wanted, strict=True))


TARGETS = {
    each.__name__: each
    for each in (
        cobs_stream,
        cobs_boards,
        cobs_driver,
        haply_reply,
        haply_board,
        haply_driver,
        slcan_lines,
    )
}
