"""Reading outputs back by SDO until all of them are at zero; what is not is written by SDO.

No process data says what an output holds, and a node that left Operational takes none. One question
is under way at a time.
"""

from __future__ import annotations

from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.layout import Output
from hil.drivers.canopen.protocol import SdoAnswer

ANSWER_TICKS = 8
"""Ticks after which a question is asked again."""
QUIET_TICKS = 4
"""While nothing is wrong, one in so many zeros is asked back, which keeps the bus's load low."""


class ZeroCheck:
    """Asks one output after the other; ``zero_codes`` are the values (16 bits) without torque."""

    def __init__(self, outputs: tuple[Output, Output], zero_codes: tuple[int, int]) -> None:
        self._outputs, self._zeros = outputs, zero_codes
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
        output = self._outputs[self._number]
        self._asked, self._ago = True, 0
        if self._stuck:
            return output.node, wire.sdo_download(output.value, self._zeros[self._number])
        return output.node, wire.sdo_upload(output.value)

    def take(self, node: int, answer: SdoAnswer) -> bool:
        """An SDO answer of a node; whether it completes a round in which every output was zero."""
        output, zero = self._outputs[self._number], self._zeros[self._number] & 0xFFFF
        if not self._asked or node != output.node or not answer.is_for(output.value):
            return False
        self._asked = False
        self._stuck = answer.value is not None and answer.value != zero
        if answer.value != zero:
            return False
        self._number = 1 - self._number
        return self._number == 0
