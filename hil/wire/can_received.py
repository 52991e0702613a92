"""What has come on a CAN bus: the newest frame of each identifier, and those nobody may miss."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field


@dataclass(slots=True)
class ReceivedFrames:
    """Data frames of others, each stamped with the number of the SYNC that it came after."""

    count: int = 0
    sync: int = 0
    """The newest SYNC's number; who begins anew counts as one."""
    answered: int = 0
    """The number of the SYNC whose answers are read."""
    events: dict[int, list[bytes]] = field(default_factory=dict[int, "list[bytes]"])
    """Identifiers of which every frame matters, with those that nobody has taken yet."""
    _own: set[int] = field(default_factory=set[int])
    _latest: dict[int, tuple[int, bytes]] = field(default_factory=dict[int, "tuple[int, bytes]"])
    _came_after: dict[int, int] = field(default_factory=dict[int, int])

    def claim(self, identifiers: Iterable[int]) -> None:
        """Frames of these identifiers are our own: udp_multicast hands a sender his."""
        self._own.update(identifiers)

    def take(self, identifier: int, data: bytes) -> bool:
        """Whether a frame is somebody else's."""
        if identifier in self._own:
            return False
        self.count += 1
        before = self._latest.get(identifier)
        self._latest[identifier] = (1 if before is None else before[0] + 1, data)
        self._came_after[identifier] = self.sync
        if identifier in self.events:
            self.events[identifier].append(data)
        return True

    def latest(self, identifier: int) -> tuple[int, bytes] | None:
        """The newest frame of an identifier: (how many came so far, data)."""
        return self._latest.get(identifier)

    def answer(self, identifier: int) -> bytes | None:
        """What answered the SYNC whose answers are read, under an identifier; ``None``: nothing."""
        if self._came_after.get(identifier, -1) < self.answered:
            return None
        return self._latest[identifier][1]

    def taken(self, identifier: int) -> Sequence[bytes]:
        """Every frame of an identifier in ``events`` since the last time."""
        frames = self.events[identifier]
        if not frames:
            return ()
        self.events[identifier] = []
        return frames
