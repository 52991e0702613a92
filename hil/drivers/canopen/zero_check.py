"""Reading back by SDO until everything that makes torque is at zero; what is not is written by SDO.

A node that left Operational sends and takes no process data, and analogue outputs never tell in
them what they hold. One question is under way at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.protocol import Object, SdoAnswer

ANSWER_TICKS = 8
"""Ticks after which a question is asked again."""
QUIET_TICKS = 4
"""While nothing is wrong, one in so many zeros is asked back, which keeps the bus's load low."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ZeroPoint:
    """An object of a node that has to be at ``zero`` (16 bits) where there is no torque."""

    node: int
    shown: Object
    zero: int = 0
    written: Object
    """Where the zero is written to when it is not."""


class ZeroCheck:
    """Asks one object after the other."""

    def __init__(self, points: Sequence[ZeroPoint]) -> None:
        self._points = points
        self.astray: str | None = None
        """After an answer: what it says that is not zero, empty where it is zero."""
        self.forget()

    def forget(self) -> None:
        """No answer that may still come says anything of what is commanded from now on."""
        self._asked = self._stuck = False
        self._number, self._ago = 0, QUIET_TICKS

    def question(self, *, urgent: bool) -> tuple[int, bytes] | None:
        """Node and SDO request to send in this tick, if any."""
        self._ago += 1
        if self._ago < (ANSWER_TICKS if self._asked else 1 if urgent else QUIET_TICKS):
            return None
        point = self._points[self._number]
        self._asked, self._ago = True, 0
        if self._stuck:
            return point.node, wire.sdo_download(point.written, point.zero)
        return point.node, wire.sdo_upload(point.shown)

    def take(self, node: int, answer: SdoAnswer) -> bool:
        """An SDO answer of a node; whether it completes a round in which everything was zero."""
        self.astray = None
        point = self._points[self._number]
        asked, zero = point.written if self._stuck else point.shown, point.zero & 0xFFFF
        if not self._asked or node != point.node or not answer.is_for(asked):
            return False
        self._asked = False
        self._stuck = answer.value is not None and answer.value != zero
        if answer.abort:
            self.astray = f"refuses to tell its output (SDO abort 0x{answer.abort:08x})"
        elif self._stuck:
            self.astray = f"was told zero, and its output is 0x{answer.value:x}"
        if self.astray is not None:
            self.astray = f"CANopen node {node} {self.astray} ({point.shown})"
        if answer.value != zero:
            return False
        self.astray = ""
        self._number = (self._number + 1) % len(self._points)
        return self._number == 0
