"""All FMUs of a run back to before tick 0 with other values, in three calls of the kernel.

For runs that are repeated thousands of times. Whatever is refused here is done once more by the
``Fmu`` itself, which says in a sentence what is wrong.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any

from cosim.master.components.participant import Participant
from cosim.master.fmu.binding import OK, Assignment
from cosim.master.fmu.instance import Fmu
from cosim.master.fmu.refusal import placed_refusal
from cosim.master.kernel.fmu_structures import RestartStruct, SettingStruct
from cosim.master.kernel.native import library
from cosim.scenario import Scenario

Times = Mapping[str, tuple[float, float]]
"""When the run of each FMU begins and ends (s)."""


class Restart:
    """What the kernel needs to restart these FMUs, kept from run to run."""

    def __init__(self, fmus: Mapping[str, Fmu]) -> None:
        """``fmus`` are initialised, and each one ``can_restart``."""
        self._fmus: list[Fmu] = list(fmus.values())
        self._names: list[str] = list(fmus)
        self._table: Any = (RestartStruct * max(len(fmus), 1))(
            *(fmu.restart() for fmu in self._fmus)
        )
        self._values: list[tuple[Any, Any]] = [(None, None)] * len(fmus)
        self._kept: list[Any] = [None] * len(fmus)
        self._times: Times | None = None
        self._participants: Mapping[str, Participant] | None = None
        self._is_under_way = False
        """Between ``begin`` and ``leave``; the FMUs themselves are told only if it ends there."""

    def begin(self, participants: Mapping[str, Participant], times: Times) -> bool:
        """Reset, set all values, enter initialisation mode; ``False`` where one is not well."""
        if times is not self._times:
            for place, name in enumerate(self._names):
                self._table[place].start, self._table[place].stop = times[name]
            self._times = times
        if participants is not self._participants and not self._take_values(participants):
            return False
        count, self._is_under_way = len(self._fmus), True
        refused: int = library().kernel_restart(ctypes.addressof(self._table), count)
        if refused < count:
            self.abandon()
            self._fmus[refused].judge(self._table[refused].status)
        return refused == count

    def abandon(self) -> None:
        """The FMUs are on their own again, wherever they have come to."""
        if self._is_under_way:
            self._is_under_way = False
            for fmu in self._fmus:
                fmu.entered_initialisation()

    def leave(self, scenario: Scenario) -> None:
        """Leave initialisation mode.

        Raises:
            InputError: an FMU refuses to: its parameters and inputs do not go together.
            RunError: it failed for good.
        """
        count = len(self._fmus)
        place: int = library().kernel_leave_initialisation(ctypes.addressof(self._table), count)
        if place == count:
            self._is_under_way = False
        else:
            self.abandon()
            for fmu in self._fmus[:place]:
                fmu.left_initialisation(OK)
            with placed_refusal(scenario, self._names[place]):
                self._fmus[place].left_initialisation(self._table[place].status)

    def _take_values(self, participants: Mapping[str, Participant]) -> bool:
        """Have all values ready; ``False`` where one does not fit its type."""
        self._participants = None
        for place, name in enumerate(self._names):
            participant = participants[name]
            parameters, start = self._values[place]
            if participant.parameters is parameters and participant.start is start:
                continue
            if not self._take(place, participant):
                return False
        self._participants = participants
        return True

    def _take(self, place: int, participant: Participant) -> bool:
        """Have an FMU's values ready; ``False`` where one does not fit its type."""
        fmu = self._fmus[place]
        try:
            ready = [
                *fmu.values.assignments(participant.parameters),
                *fmu.values.assignments(participant.start),
            ]
        except (ValueError, TypeError, OverflowError, ctypes.ArgumentError):
            return False
        settings = (SettingStruct * max(len(ready), 1))(
            *(_setting(function, each) for function, each in ready)
        )
        self._table[place].settings = ctypes.addressof(settings)
        self._table[place].setting_count = len(ready)
        self._kept[place] = settings, ready
        self._values[place] = participant.parameters, participant.start
        return True


def _setting(function: int, each: Assignment) -> SettingStruct:
    return SettingStruct(
        function,
        ctypes.addressof(each.references),
        len(each.references),
        ctypes.addressof(each.values),
        len(each.values),
    )
