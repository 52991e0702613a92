"""What the devices of one run share: once one of them is in FAULT, all of them are brought to zero.

A fault that is found while reading brings the others to zero in the same tick, because all devices
read before any writes; one that is found while writing does so at the next.
"""

from __future__ import annotations


class Alarm:
    """Raised by every device that goes into FAULT, until that device is reset."""

    def __init__(self) -> None:
        self._raised: list[str] = []

    @property
    def raised_by(self) -> str | None:
        """The first device that is still in FAULT."""
        return self._raised[0] if self._raised else None

    def raise_for(self, name: str) -> None:
        """A device is in FAULT."""
        self._raised.append(name)

    def withdraw(self, name: str) -> None:
        """It was reset."""
        self._raised.remove(name)
