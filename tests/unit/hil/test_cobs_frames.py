"""The framed protocol: nothing damaged is accepted, and two frames suffice to be in step again."""

from __future__ import annotations

import ctypes
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.drivers.cobs.emulator import _Device
from hil.drivers.cobs.protocol import CommandFlag, ReplyFlag, command, reply
from hil.firmware.build import build
from hil.wire.cobs_frames import Splitter, crc, frame, payload, stuff, unstuff

torques = st.tuples(st.floats(-1, 1, width=32), st.floats(-1, 1, width=32))


def test_the_published_check_value_of_the_checksum():
    assert crc(b"123456789") == 0x29B1


@settings(deadline=None)
@given(st.binary(max_size=200))
def test_stuffing_is_undone_and_has_no_zero(data):
    assert 0 not in stuff(data)
    assert unstuff(stuff(data)) == data


@settings(deadline=None)
@given(st.binary(max_size=300))
def test_noise_never_raises_and_is_never_a_reply(data):
    for body in Splitter().feed(data):
        assert crc(body) is not None
        reply(body)
    assert payload(data) is None or frame(payload(data))[:-1] == data


@settings(deadline=None, derandomize=True)
@given(torques, st.integers(0, 143), st.integers(0, 143))
def test_one_or_two_flipped_bits_on_the_wire_are_noticed(torque, first, second):
    whole = command(CommandFlag.ENABLE, 7, torque, 20)
    spoiled = bytearray(whole)
    for bit in {first % (8 * len(whole)), second % (8 * len(whole))}:
        spoiled[bit // 8] ^= 1 << bit % 8
    original = Splitter().feed(whole)
    found = Splitter().feed(bytes(spoiled) + b"\0")
    assert found in ([], original)


@settings(deadline=None)
@given(st.binary(max_size=100), torques)
def test_after_noise_the_second_frame_is_read(noise, torque):
    splitter = Splitter()
    splitter.feed(noise)
    frames = [command(CommandFlag(0), number, torque, 20) for number in (1, 2)]
    found = [body for each in frames for body in splitter.feed(each)]
    assert found[-1] == payload(frames[1][:-1])


class Firmware:
    """The C reference through ctypes."""

    def __init__(self, library):
        self.library, self.device = library, _Device()
        library.device_init(ctypes.byref(self.device))

    def feed(self, data, now=0, count=(0, 0)):
        out, answer = b"", (ctypes.c_uint8 * 24)()
        counts = (ctypes.c_int32 * 2)(*count)
        for byte in data:
            size = self.library.device_receive(
                ctypes.byref(self.device),
                ctypes.c_uint8(byte),
                ctypes.c_uint32(now),
                counts,
                answer,
            )
            out += bytes(answer)[:size]
        return out

    @property
    def torque(self):
        return tuple(self.device.torque)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    made = ctypes.CDLL(str(build(tmp_path_factory.mktemp("firmware"))))
    made.device_receive.restype = ctypes.c_size_t
    return made


@settings(deadline=None)
@given(torques, st.integers(0, 0xFFFF), st.tuples(*[st.integers(-(2**31), 2**31 - 1)] * 2))
def test_the_c_reference_answers_what_the_driver_reads(library, torque, sequence, count):
    board = Firmware(library)
    sent = command(CommandFlag.ENABLE | CommandFlag.CLEAR, sequence, torque, 20)
    (body,) = Splitter().feed(board.feed(sent, 1234, count))
    answer = reply(body)
    assert (answer.sequence, answer.count, answer.microseconds) == (sequence, count, 1234)
    assert board.torque == torque
    assert ReplyFlag.ENABLED in answer.status
    assert (ReplyFlag.ZERO in answer.status) is (torque == (0.0, 0.0))


@settings(deadline=None)
@given(st.lists(st.binary(max_size=80), max_size=6))
def test_noise_gives_the_c_reference_no_torque(library, noise):
    board = Firmware(library)
    for part in noise:
        board.feed(part)
    assert board.torque == (0.0, 0.0)
    board.feed(b"\0")
    board.feed(command(CommandFlag.ENABLE, 1, (0.25, -0.5), 20))
    assert board.torque == (0.25, -0.5)


def test_the_watchdog_of_the_c_reference_drops_the_torque_and_stays_fired(library):
    board = Firmware(library)
    board.feed(command(CommandFlag.ENABLE, 1, (0.1, 0.1), 20), now=2**32 - 5000)
    library.device_tick(ctypes.byref(board.device), ctypes.c_uint32(14_000))
    assert board.torque != (0.0, 0.0), "the clock may wrap"
    library.device_tick(ctypes.byref(board.device), ctypes.c_uint32(16_000))
    assert board.torque == (0.0, 0.0)
    board.feed(command(CommandFlag.ENABLE, 2, (0.1, 0.1), 20), now=17_000)
    assert board.torque == (0.0, 0.0)
    board.feed(command(CommandFlag.ENABLE | CommandFlag.CLEAR, 3, (0.5, 0.5), 20), now=18_000)
    assert board.torque == (0.5, 0.5)


def test_what_is_no_number_is_no_torque(library):
    board = Firmware(library)
    bad = frame(struct.pack("<BBHffH", 1, 1, 1, float("nan"), 0.1, 20))
    assert board.feed(bad) == b""
    assert board.torque == (0.0, 0.0)
