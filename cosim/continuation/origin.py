"""What ``run --from`` names: an earlier run, and a time in it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.master.assembly.clock import Clock
from cosim.record.reader import SCENARIO_FILE

if TYPE_CHECKING:
    from cosim.scenario import Scenario


def tick_at(time: str, scenario: Scenario, option: str) -> int:
    """A time that was given (``2.5s``, or seconds) as a tick, which counts from the start.

    Raises:
        InputError: it is no time, below 0, or between two ticks.
    """
    try:
        ticks = quantity(time, "s") * scenario.base_rate - scenario.start_tick
    except QuantityError as error:
        raise InputError(f"{option}: '{time}' is not a time: {error}") from None
    if ticks < 0:
        raise InputError(f"{option}: {time} lies before the run.")
    if ticks.denominator != 1:
        around = [int(ticks), int(ticks) + 1]
        clock = Clock(scenario.base_rate, scenario.start_tick)
        near = " and ".join(f"{clock.seconds(tick):.10g} s (tick {tick})" for tick in around)
        raise InputError(f"{option}: {time} lies between two ticks; the nearest are {near}.")
    return int(ticks)


@dataclass(frozen=True, slots=True)
class Origin:
    """An earlier run, and the time in it from which to go on."""

    folder: Path
    time: str

    @staticmethod
    def read(text: str) -> Origin:
        """From ``RUN@TIME``.

        Raises:
            InputError: it is not written so.
        """
        folder, at, time = text.rpartition("@")
        if not at or not folder or not time:
            raise InputError(
                f"--from takes a run's folder and a time, such as runs/box-1@2.5s, not '{text}'."
            )
        return Origin(Path(folder), time)


def scenario_to_run(
    scenario: str | None, origin: str | None, *, changed: bool, special: bool, realtime: bool
) -> str:
    """The scenario that was given, or the one that an earlier run has resolved.

    Raises:
        InputError: none or both were given, or what does not go together.
    """
    if (scenario is None) == (origin is None):
        raise InputError(
            "Name a scenario (a file, or a bundled one such as two_users_box), or a run to go on "
            "from with --from, and not both."
        )
    if special and realtime:
        raise InputError(
            "--snapshot and --from are for runs that do not keep pace; leave --realtime out."
        )
    if origin is None:
        return str(scenario)
    if changed:
        raise InputError(
            "--from goes on with the run's own scenario: leave --set and --with out; only "
            "--duration may differ."
        )
    file = Origin.read(origin).folder / SCENARIO_FILE
    if not file.is_file():
        raise InputError(f"--from: {file.parent} is no run's folder: it has no {SCENARIO_FILE}.")
    return str(file)
