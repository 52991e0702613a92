"""When the scenario of a system structure begins, and how long it runs."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import QuantityError, decimal, format_exact, quantity
from cosim.ssp.structure import SspStructure


def start_of(structure: SspStructure, own: Mapping[str, Any]) -> Fraction:
    """When time begins (s), by our own annotation where that says it.

    Raises:
        InputError: it is no time.
    """
    if "start_time" in own:
        try:
            return quantity(own["start_time"], "s")
        except (QuantityError, TypeError):
            raise InputError(
                f"the annotation of {structure.file.name} has the start_time {own['start_time']}."
            ) from None
    if structure.start is None:
        return Fraction(0)
    return _seconds(structure, "startTime", structure.start)


def duration_of(
    structure: SspStructure, own: dict[str, Any], start: Fraction, stop_time: Fraction | None
) -> Any:
    """How long to run; taken out of ``own`` where that says it.

    Raises:
        InputError: nobody says it, or it would end before it begins.
    """
    if stop_time is not None:
        own.pop("duration", None)
        return _between(structure, start, stop_time)
    if "duration" in own:
        return own.pop("duration")
    if structure.stop is None:
        raise InputError(f"{structure.file.name} does not say how long to run; give --stop-time.")
    return _between(structure, start, _seconds(structure, "stopTime", structure.stop))


def _seconds(structure: SspStructure, what: str, text: str) -> Fraction:
    try:
        return decimal(text)
    except ValueError:
        raise InputError(
            f"the {what} of {structure.file.name} is {text}, which is no time to run at."
        ) from None


def _between(structure: SspStructure, start: Fraction, stop: Fraction) -> str:
    if stop <= start:
        raise InputError(
            f"{structure.file.name} begins at {float(start):g} s and would stop at "
            f"{float(stop):g} s; give a later --stop-time."
        )
    return format_exact(stop - start)
