"""The port of a Haply's driver with motors at its other end, in this very process."""

from __future__ import annotations

from tests.support.hil.motors.haply import Haply


class Line:
    """The port of a driver, with motors at its other end."""

    def __init__(self, motors: Haply, late: int = 0) -> None:
        """``late``: looks at the line until an answer is there."""
        self.motors, self.told = motors, (0.0, 0.0)
        self.commands: list[tuple[float, ...]] = []
        self._late, self._looks = late, 0
        self._answers = b""

    def write(self, frame: bytes) -> None:
        for each in self.motors.feed(frame):
            if each.torques:
                self.told = each.torques
                self.commands.append(each.torques)
                self._looks = 0
            self._answers += each.answer

    def read(self, most: int = 4096) -> bytes:
        del most
        self._looks += 1
        if self._looks <= self._late:
            return b""
        found, self._answers = self._answers, b""
        return found

    def wait(self, count: int, seconds: float) -> bytes:
        del seconds
        while not (found := self.read(count)):
            pass
        return found

    def exchange_done(self) -> None: ...

    def close(self) -> None: ...
