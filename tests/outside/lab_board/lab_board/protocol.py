"""Lines of text with a checksum: pure functions, no port and no state.

Command ``T 17 1200 -300 *1a2b``: what to do, sequence number, two torques in uN.m. Z: output stage
off. C: on, and forget a watchdog that fired. T: torque, obeyed only after a C: a board that was
reset, or whose watchdog fired, stays off until its host has noticed. Every valid command is
answered by ``A 17 20113 -4001 5 *9f03``: its number, two counts, what the board says of itself.
"""

from __future__ import annotations

import binascii
from dataclasses import dataclass

OFF, CLEAR, TORQUE = "Z", "C", "T"
ENABLED, FIRED, ZERO = 1, 2, 4
LONGEST_LINE = 64
LARGEST_TORQUE = 10_000_000


@dataclass(frozen=True, slots=True)
class Command:
    """What the host asks for."""

    kind: str
    sequence: int
    torque: tuple[int, int]


@dataclass(frozen=True, slots=True)
class Answer:
    """What the board says."""

    sequence: int
    count: tuple[int, int]
    status: int


def line(*words: object) -> bytes:
    """A line with its checksum."""
    body = " ".join(map(str, words)).encode()
    return b"%s *%04x\n" % (body, binascii.crc_hqx(body, 0xFFFF))


def command(data: bytes) -> Command | None:
    """The command in a line; ``None`` where it is none, or damaged."""
    words = _words(data)
    if len(words) != 4 or words[0] not in {OFF, CLEAR, TORQUE}:
        return None
    numbers = _numbers(words[1:])
    if numbers is None or max(abs(numbers[1]), abs(numbers[2])) >= LARGEST_TORQUE:
        return None
    return Command(words[0], numbers[0], (numbers[1], numbers[2]))


def answer(data: bytes) -> Answer | None:
    """The answer in a line; ``None`` where it is none, or damaged."""
    words = _words(data)
    numbers = _numbers(words[1:]) if len(words) == 5 and words[0] == "A" else None
    if numbers is None:
        return None
    return Answer(numbers[0], (numbers[1], numbers[2]), numbers[3])


def _words(data: bytes) -> list[str]:
    body, star, _ = data.partition(b" *")
    if not star or data + b"\n" != line(body.decode("ascii", "replace")):
        return []
    return body.decode("ascii").split(" ")


def _numbers(words: list[str]) -> list[int] | None:
    try:
        return [int(word) for word in words]
    except ValueError:
        return None


class Lines:
    """Whole lines out of a stream of bytes."""

    def __init__(self) -> None:
        self._pending = b""

    def feed(self, data: bytes) -> list[bytes]:
        """The lines that end in ``data``; what is too long to be one is dropped."""
        *whole, self._pending = (self._pending + data).split(b"\n")
        self._pending = self._pending[-LONGEST_LINE:]
        return whole
