"""Whether a board takes a command at every tick, or is always late and runs at a lower rate."""

from __future__ import annotations

WINDOW_SECONDS = 1.0
LARGEST_SHARE = 0.25
"""A board that took no command in more of a window's ticks than this is late as a rule."""


class Punctuality:
    """Counts the commands of a device that is active; ``tick`` is the control period (s)."""

    def __init__(self, tick: float) -> None:
        self._tick = tick
        self._window = max(1, round(WINDOW_SECONDS / tick))
        self._commands = self._unsent = 0
        self.rate: float | None = None
        """Commands a second that it took in the worst window, where it was late as a rule (Hz)."""

    def count(self, *, sent: bool) -> None:
        """One more command, which went out or did not."""
        self._commands += 1
        self._unsent += not sent
        if self._commands < self._window:
            return
        share = self._unsent / self._commands
        if share > LARGEST_SHARE:
            taken = (1.0 - share) / self._tick
            self.rate = taken if self.rate is None else min(self.rate, taken)
        self._commands = self._unsent = 0

    def sentence(self, name: str) -> str | None:
        """What has to be said of the device ``name``, ``None`` where it is in time."""
        if self.rate is None:
            return None
        return (
            f"{name} took {self.rate:.0f} commands a second instead of {1 / self._tick:.0f}: its "
            "answers come later than a tick; what was not sent was held. Lower the control rate, "
            "or look at the adapter's latency timer"
        )
