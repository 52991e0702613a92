"""What the simulations of a worker are doing, in a file that outlives the worker."""

from __future__ import annotations

from typing import IO

from cosim.base.system.room import nameless_shared_file
from cosim.master.run.obituary import obituary
from cosim.master.run.whereabouts import SPAN, Whereabouts
from cosim.scenario import Scenario

PLACES = 6
"""One for each plan that is kept ready, and for the run from nothing that is compared."""


class Traces:
    """A place for each simulation; without a file nobody else sees them."""

    def __init__(self, file: int | None = None) -> None:
        """``file`` is one of ``traces_file``."""
        self._free = [] if file is None else [Whereabouts(file, n) for n in range(PLACES)]

    def take(self) -> Whereabouts:
        """A place that nobody has."""
        return self._free.pop() if self._free else Whereabouts()

    def give_back(self, place: Whereabouts) -> None:
        """It can be taken again; what it held is over."""
        place.forget()
        self._free.append(place)


def traces_file() -> IO[bytes]:
    """An open file for the places of a worker.

    Raises:
        RunError: there is no room for it.
    """
    return nameless_shared_file(PLACES * SPAN, "what a worker of a sweep is doing")


def last_words(file: int, status: int, scenario: Scenario) -> str:
    """Who ended a worker, how, in what and when, without a full stop; ``status`` is its own."""
    places = [Whereabouts(file, number) for number in range(PLACES)]
    at_work = next((place for place in places if place.sentence(scenario)[0]), places[0])
    return obituary(status, at_work, scenario)
