"""What options of the theory commands are written as: settings, ratios, ranges, delays."""

from __future__ import annotations

from fractions import Fraction

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import decimal
from cosim.theory.models.timing import PathDelay


def read_setting(text: str) -> tuple[str, float]:
    """Read ``name=value``.

    Raises:
        InputError: where it has another form, or the value is not a number.
    """
    name, separator, value = text.partition("=")
    if not separator or not name.strip():
        raise InputError(f"--set {text}: write NAME=VALUE, such as --set k_11=2000.")
    try:
        return name.strip(), float(value)
    except ValueError:
        raise InputError(
            f"--set {text}: {value.strip()!r} is not a number; give it in SI units, such as 2000."
        ) from None


def read_fraction(option: str, text: str) -> Fraction:
    """Read a positive number, exactly: ``8``, ``17/2`` or ``8.5``.

    Raises:
        InputError: where it is not one.
    """
    try:
        number, _, divisor = text.partition("/")
        value = decimal(number) / decimal(divisor or "1")
    except (ValueError, ZeroDivisionError):
        raise InputError(
            f"{option} {text}: give a positive number such as 8, 17/2 or 8.5."
        ) from None
    if value <= 0:
        raise InputError(f"{option} {text}: it must be positive.")
    return value


def read_range(text: str, option: str = "--range", example: str = "1:50000") -> tuple[float, float]:
    """Read an option's ``LOW:HIGH``.

    Raises:
        InputError: where it has another form.
    """
    low, separator, high = text.partition(":")
    try:
        if separator:
            return float(low), float(high)
    except ValueError:
        pass
    raise InputError(f"{option} {text}: write LOW:HIGH, such as {example}.")


def read_delay(
    round_trip: int | None, each_way: int | None, forward: int | None, backward: int | None
) -> PathDelay:
    """The delay from exactly one of its three forms; none of them means no delay.

    Raises:
        InputError: where two forms are mixed.
    """
    both = forward is not None or backward is not None
    if sum((round_trip is not None, each_way is not None, both)) > 1:
        raise InputError(
            "Give the delay in one form only: --round-trip-delay, --each-way-delay, or "
            "--forward-delay with --backward-delay."
        )
    if round_trip is not None:
        return PathDelay.round_trip(round_trip)
    if each_way is not None:
        return PathDelay.each_way(each_way)
    return PathDelay(forward or 0, backward or 0)
