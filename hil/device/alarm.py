"""What the devices of one run share: once one of them is in FAULT, all of them are brought to zero.

A fault that is found while reading brings the others to zero in the same tick, because all devices
read before any writes; one that is found while writing does so at the next.
"""

from __future__ import annotations


class Alarm:
    """Raised by the first device that goes into FAULT."""

    def __init__(self) -> None:
        self.raised_by: str | None = None

    def raise_for(self, name: str) -> None:
        """A device is in FAULT."""
        if self.raised_by is None:
            self.raised_by = name
