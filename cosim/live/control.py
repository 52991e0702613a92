"""What a page asks of the run it plays in: pause, one step, slow motion, restart.

One row in shared memory: the server writes it, the loop's pacer and the command read it.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self, cast

from cosim.realtime.ring import Ring

SPEEDS = (1.0, 0.5, 0.25, 0.1)
CELLS = 4


class PlayControl:
    """Speed, pause, and counts of steps and restarts."""

    def __init__(self, ring: Ring) -> None:
        self._ring = ring
        self._row = [1.0, 0.0, 0.0, 0.0]

    @classmethod
    def create(cls) -> Self:
        """A new one: full speed, going on.

        Raises:
            RunError: there is no room for it in shared memory.
        """
        made = cls(Ring.create(CELLS, capacity=16, what="the buttons of a page"))
        made.put()
        return made

    @classmethod
    def attach(cls, path: Path) -> Self:
        """One that another process has made."""
        made = cls(Ring(path))
        made.look()
        return made

    @property
    def path(self) -> Path:
        """Where others attach."""
        return self._ring.path

    @property
    def changes(self) -> int:
        """How often something was asked."""
        return int(self._ring.head[1])

    def look(self) -> None:
        """Take what is asked now."""
        row = self._ring.newest()
        if row is not None:
            self._row = row.tolist()

    def put(self) -> None:
        """Let the others see it."""
        self._ring.write(self._row)

    @property
    def speed(self) -> float:
        """Of the run against the clock, at most 1."""
        return self._row[0]

    @property
    def paused(self) -> bool:
        """Whether no tick runs but those of ``steps``."""
        return self._row[1] > 0.0

    @property
    def steps(self) -> int:
        """How many single steps were asked for."""
        return int(self._row[2])

    @property
    def restarts(self) -> int:
        """How often a fresh start was asked for."""
        return int(self._row[3])

    def told(self) -> dict[str, Any]:
        """For the page."""
        return {"speed": self.speed, "paused": self.paused, "speeds": SPEEDS}

    def hear(self, wish: Any) -> bool:
        """Take what a page asks for; whether it was understood."""
        if not isinstance(wish, Mapping):
            return False
        asked = cast("Mapping[str, Any]", wish)
        before = list(self._row)
        if asked.get("speed") in SPEEDS:
            self._row[0] = float(asked["speed"])
        if isinstance(asked.get("paused"), bool):
            self._row[1] = float(asked["paused"])
        self._row[2] += asked.get("step") is True
        self._row[3] += asked.get("restart") is True
        if self._row == before:
            return False
        self.put()
        return True

    def remove(self) -> None:
        """Nobody needs it any more."""
        self._ring.remove()
