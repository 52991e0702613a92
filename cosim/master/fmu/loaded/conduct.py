"""How an FMU behaves: what its statuses mean, what it said, and what it did beside its work."""

from __future__ import annotations

from collections import Counter
from typing import NoReturn

from cosim.base.errors import InputError, RunError
from cosim.master.fmu.binding import DISCARD, FATAL, OK, WARNING
from cosim.master.fmu.loaded.residence import Residence
from cosim.master.fmu.log import STATUS_NAMES, Said

AFTER_FATAL = "after a fatal status nothing more can be run with it"


class Conduct:
    """Of one instance."""

    def __init__(self, component: str, residence: Residence) -> None:
        self.is_lost = False
        """Whether a fatal status came back: nothing may be called any more, not even to free it."""
        self.has_failed = False
        """Whether an error came back: it may only be freed."""
        self._component = component
        self._residence = residence
        self._changed: Counter[str] = Counter()
        self._lapses: Counter[str] = Counter()

    def judge(self, status: int) -> None:
        """Take note of what a call returned."""
        self.has_failed = self.has_failed or status not in {OK, WARNING, DISCARD}
        self.is_lost = self.is_lost or status == FATAL or self._residence.is_gone

    def forget(self) -> None:
        """Judge anew: there is another instance."""
        self.is_lost = self.has_failed = False

    def check_start(self, what: str, status: int) -> None:
        """A step of the start-up: what an FMU refuses before it has run is what it was given.

        Raises:
            InputError: it refuses the step.
            RunError: it failed for good.
        """
        if status in {OK, WARNING}:
            return
        self.judge(status)
        kind = RunError if status == FATAL else InputError
        raise kind(
            f"{self._component}: the FMU refused to {what} (status {status_word(status)})"
            f"{self.reasons()}"
        )

    def refuse_value(self, value: str, status: int) -> NoReturn:
        """A value that it was given was not well, which ``value`` tells.

        Raises:
            InputError: it refuses the value.
            RunError: it failed for good.
        """
        self.judge(status)
        kind = RunError if status == FATAL else InputError
        word = " (status fatal)" if status == FATAL else ""
        raise kind(f"{self._component}: the FMU refuses {value}{word}{self.reasons()}")

    def check_state(self, what: str, status: int, when: str) -> None:
        """A call about its state; ``when`` is empty, or begins with a blank.

        Raises:
            RunError: it was not well.
        """
        if status in {OK, WARNING}:
            return
        self.judge(status)
        raise RunError(
            f"{self._component}: the FMU cannot {what}{when} (status {status_word(status)})"
            f"{self.reasons()}"
        )

    def reasons(self) -> str:
        """What it gave as a reason, as the end of a sentence; empty where there is nothing."""
        return self._residence.log.reason()

    def messages(self) -> list[str]:
        """What it gave as a reason, oldest first, each text once."""
        return self._residence.log.reasons()

    def said(self) -> tuple[Said, ...]:
        """What it logged as a warning or worse, and what it changed outside of itself."""
        logged = self._residence.log.said()
        if not self._changed and not self._lapses:
            return logged
        changed = (
            Said("warning", f"it changed {what}, which was put back", count)
            for what, count in self._changed.items()
        )
        lapses = (Said("warning", what, count) for what, count in self._lapses.items())
        return (*logged, *changed, *lapses)

    def disturbed(self, what: str) -> None:
        """It has changed what belongs to the process."""
        self._changed[what] += 1

    def lapse(self, what: str) -> None:
        """It has done what the standard does not allow, and what was made good."""
        self._lapses[what] += 1


def status_word(status: int) -> str:
    """A status as a word; a number that the standard does not have as itself."""
    return STATUS_NAMES[status] if 0 <= status < len(STATUS_NAMES) else str(status)
