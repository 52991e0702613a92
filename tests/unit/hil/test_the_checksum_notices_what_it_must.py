"""The framed protocol: what CRC-16 has to notice by its theory is noticed, and so is all that was
injected into whole frames on the wire.

A checksum is linear: an error is noticed exactly where its own syndrome is not zero, whatever the
frame holds. So every error of a class can be counted through, on the product's own function.
"""

from __future__ import annotations

import random
import struct

import numpy as np
import pytest

from hil.drivers.cobs.protocol import CommandFlag, command
from hil.wire.cobs_frames import Splitter, crc, frame, payload
from tests.fuzz import oracle

BODIES = {"command": 14, "reply": 18}
"""Bytes in front of the checksum."""


def syndromes(size: int) -> np.ndarray:
    """Of every single flipped bit of a codeword (first byte first, its highest bit first)."""
    body = bytes(random.Random(size).randbytes(size))
    right, found = crc(body), []
    for bit in range(8 * size):
        spoiled = bytearray(body)
        spoiled[bit // 8] ^= 0x80 >> bit % 8
        found.append(crc(bytes(spoiled)) ^ right)
    return np.array([*found, *(1 << bit for bit in range(15, -1, -1))])


@pytest.mark.parametrize("size", BODIES.values(), ids=BODIES)
def test_every_one_and_two_bit_error_of_a_codeword_is_noticed(size: int):
    single = syndromes(size)
    assert len(single) == 8 * (size + 2)
    assert single.all()
    assert len(set(single.tolist())) == len(single), "two flips that cancel"


@pytest.mark.parametrize("size", BODIES.values(), ids=BODIES)
def test_every_burst_of_up_to_16_bits_is_noticed(size: int):
    """Also one that reaches into the checksum, because that travels high byte first."""
    single, seen = syndromes(size), 0
    for start in range(len(single)):
        window = single[start : start + 16]
        patterns = np.zeros(1, np.int64) ^ window[0]
        for bit in window[1:]:
            patterns = np.concatenate([patterns, patterns ^ bit])
        assert patterns.all()
        seen += len(patterns)
    assert seen > 2**15 * 8 * size * 0.8


def test_the_product_and_the_definition_compute_one_checksum():
    numbers = random.Random(3)
    for length in range(64):
        data = numbers.randbytes(length)
        assert crc(data) == oracle.crc16(data)
        assert payload(frame(data)[:-1]) == (data or None)
        assert oracle.payloads(frame(data)) == ([data] if data else [])


def frames(count: int) -> list[bytes]:
    """Commands and replies as they occur, the same ones every time."""
    numbers = random.Random(11)
    made = []
    for number in range(count):
        push = (numbers.choice((0.0, numbers.uniform(-0.2, 0.2))), numbers.uniform(-0.2, 0.2))
        counts = (numbers.randrange(-30000, 30000), numbers.randrange(-30000, 30000))
        made += [
            command(CommandFlag.ENABLE, number, push, 20),
            frame(struct.pack("<BBHIiiH", 0x81, 1, number, 977 * number, *counts, number % 9)),
        ]
    return made


def accepted(spoiled: bytes, original: bytes) -> bool:
    """Whether something that was not sent came through as a message of that kind and length."""
    return any(
        body != original and (len(body), body[0]) == (len(original), original[0])
        for body in Splitter().feed(spoiled + b"\0")
    )


def test_no_spoiled_frame_on_the_wire_is_accepted():
    """Stuffing turns one flipped bit into several, so here the count is evidence and not proof."""
    injected = wrong = 0
    numbers = random.Random(7)
    for whole in frames(6):
        original, bits = payload(whole[:-1]), 8 * len(whole)
        assert original is not None
        value = int.from_bytes(whole, "big")

        def sent(error: int, size: int = len(whole), value: int = value) -> bytes:
            return (value ^ error).to_bytes(size, "big")

        for first in range(bits):
            errors = [1 << first, *(1 << first | 1 << n for n in range(first % 8, first, 8))]
            for _ in range(20):
                length = numbers.randrange(3, 17)
                burst = numbers.getrandbits(length) | 1 | 1 << length - 1
                errors.append(burst << numbers.randrange(bits - length + 1))
            for error in errors:
                injected += 1
                wrong += accepted(sent(error), original)
        for place in range(len(whole) - 1):
            for cut in range(1, len(whole) - place):
                injected += 1
                wrong += accepted(whole[:place] + whole[place + cut :], original)
            for extra in range(256):
                injected += 1
                wrong += accepted(whole[:place] + bytes((extra,)) + whole[place:], original)
    assert injected > 100_000
    assert wrong == 0
