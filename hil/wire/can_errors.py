"""Error frames: what a CAN controller says of its bus.

Source: Linux, include/uapi/linux/can/error.h (the class is in the identifier, details in the data).
"""

from __future__ import annotations

from dataclasses import dataclass

CONTROLLER, NO_ACKNOWLEDGE, BUS_OFF, RESTARTED = 0x04, 0x20, 0x40, 0x100
_WARNING, _PASSIVE = 0x0C, 0x30
"""Of data byte 1, where the class is ``CONTROLLER``."""


@dataclass(frozen=True, slots=True)
class BusTrouble:
    """What is wrong with a bus, as a part of a sentence."""

    said: str
    is_off: bool = False
    """Whether the controller has left the bus: nothing goes out any more."""


def trouble(identifier: int, data: bytes) -> BusTrouble:
    """What an error frame says."""
    if identifier & BUS_OFF:
        return BusTrouble(
            "the CAN controller went bus-off: look at the wiring, the terminating resistors and "
            "the bit rate, and bring the interface up again",
            is_off=True,
        )
    if identifier & NO_ACKNOWLEDGE:
        return BusTrouble(
            "nobody acknowledges our frames: is the device on, and connected to this bus?"
        )
    if identifier & RESTARTED:
        return BusTrouble("the CAN controller was restarted")
    if identifier & CONTROLLER and len(data) > 1:
        if data[1] & _PASSIVE:
            return BusTrouble("the CAN controller is error-passive: the bus is disturbed")
        if data[1] & _WARNING:
            return BusTrouble("the CAN controller warns of many errors on the bus")
    return BusTrouble(f"the CAN controller reports an error (class 0x{identifier:x})")
