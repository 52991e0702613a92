"""Whose hand a page moves: each user of the run is taken by one page at a time.

A page says where its pointer is in every frame it draws; who says nothing is not there, and
``cosim.live.pointer`` sees that by the age of the last word. A user whom nobody has taken does as
the others do, in their own place: a partner who helps.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections import deque
from collections.abc import Mapping
from typing import Any, cast

from cosim.live.control import PlayControl
from cosim.live.knobs.panels import Panels
from cosim.live.mailbox import FINGERS, Mailbox
from cosim.live.viewer import Viewer

FARTHEST = 10.0
"""A pointer beyond (m) is a mistake."""
NOTED = 64
"""Samples whose times are remembered, to tell a page which one it sees."""
SHOWN = 8
"""Of those, what a frame tells."""
WINDOW_SECONDS = 5.0
"""Over so long the quickest message says how a page's clock and ours stand to each other."""


class _Clock:
    """A page's clock as ours: the message that took least, of those of a window."""

    def __init__(self) -> None:
        self._offset, self._since = math.inf, 0.0

    def ours(self, theirs: float) -> float:
        """When something happened by our clock (s), which the page says by its own."""
        now = time.monotonic()
        if now - self._since > WINDOW_SECONDS:
            self._offset, self._since = math.inf, now
        self._offset = min(self._offset, now - theirs)
        return theirs + self._offset


class Seats:
    """The users of a run, their mailboxes, and the pages that hold them.

    Without a ``control`` the run keeps its pace, as one over a real link has to.
    """

    def __init__(
        self,
        mailboxes: Mapping[str, Mailbox],
        control: PlayControl | None = None,
        panels: Panels | None = None,
        theory: Mapping[str, Any] | None = None,
    ) -> None:
        self._mailboxes = mailboxes
        self._panels = panels or Panels([], {})
        self.theory = theory
        """What is known of the run at its knobs' values, for the page."""
        self._control = control
        self.moved = asyncio.Event()
        """A hand has moved, and its effect is not drawn yet."""
        self._held: dict[str, Viewer] = {}
        self._clocks: dict[str, _Clock] = {}
        self._middles: dict[str, list[float]] = {}
        self._times = {user: deque[tuple[int, float]](maxlen=NOTED) for user in mailboxes}

    def follow(self, scene: Mapping[str, Any]) -> None:
        """A run begins: where the hands of its users are in their middle."""
        self._middles = {
            pointer["station"]: [x for finger in pointer["fingers"] for x in finger["reach"][:2]]
            for pointer in scene.get("pointers", ())
        }

    def seat(self, viewer: Viewer) -> None:
        """Give a page that comes the first user who is free."""
        free = next((user for user in self._mailboxes if user not in self._held), None)
        if free is not None:
            self._take(viewer, free)

    def leave(self, viewer: Viewer) -> None:
        """A page is gone, or only looks on."""
        user, viewer.user = viewer.user, None
        if user is not None and self._held.get(user) is viewer:
            del self._held[user]
            box = self._mailboxes[user]
            last = box.newest()
            box.post(time.monotonic(), last[2:] if last else [0.0] * 2 * FINGERS, present=False)

    def told(self, viewer: Viewer) -> dict[str, Any]:
        """What a page has to know of the seats."""
        return {
            "type": "seats",
            "user": viewer.user,
            "users": list(self._mailboxes),
            "taken": sorted(self._held),
            "control": None if self._control is None else self._control.told(),
            "knobs": self._panels.told(),
        }

    def seen(self) -> dict[str, list[list[float]]]:
        """By user, number and page's time (ms) of the newest samples."""
        return {
            user: [list(each) for each in list(times)[-8:]] for user, times in self._times.items()
        }

    def hear(self, viewer: Viewer, message: Mapping[str, Any]) -> bool:
        """Take what a page says of its hand; whether the seats have changed."""
        user = message.get("user", viewer.user)
        if user is None and viewer.user is not None:
            self.leave(viewer)
            return True
        if user != viewer.user and user in self._mailboxes and user not in self._held:
            self.leave(viewer)
            self._take(viewer, cast("str", user))
            return True
        if viewer.user is not None and "hand" in message:
            self._hand(viewer.user, message["hand"])
        if viewer.user is not None and self._control is not None and "control" in message:
            return self._control.hear(message["control"])
        if viewer.user is not None and "knobs" in message:
            return self._panels.hear(message["knobs"])
        return False

    def _take(self, viewer: Viewer, user: str) -> None:
        self._held[user] = viewer
        viewer.user = user
        self._clocks[user] = _Clock()

    def _hand(self, user: str, hand: Any) -> None:
        """``[page's time in ms, x1, y1, x2, y2]``; what is no such list is dropped."""
        if not isinstance(hand, list) or len(cast("list[Any]", hand)) != 1 + 2 * FINGERS:
            return
        values = cast("list[Any]", hand)
        if not all(type(value) in {int, float} and math.isfinite(value) for value in values):
            return
        if max(abs(value) for value in values[1:]) > FARTHEST:
            return
        last = self._mailboxes[user].newest()
        if last is None or last[2:] != values[1:]:
            self.moved.set()
        when = self._clocks[user].ours(values[0] * 1e-3)
        number = self._mailboxes[user].post(when, values[1:], present=True)
        self._times[user].append((number, values[0]))
        self._help(user, when, values[1:])

    def _help(self, user: str, when: float, positions: list[float]) -> None:
        """Who is free does the same."""
        own = self._middles.get(user)
        for other, box in self._mailboxes.items():
            theirs = self._middles.get(other)
            if other in self._held or own is None or theirs is None:
                continue
            moved = [p - a + b for p, a, b in zip(positions, own, theirs, strict=True)]
            box.post(when, moved, present=True)
