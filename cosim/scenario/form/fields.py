"""The values a scenario is written with: rates, times, delays, probabilities, references."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, Literal, cast

from pydantic import PlainValidator, WithJsonSchema

from cosim.base.document.form import problem
from cosim.base.document.show import describe
from cosim.base.quantities.quantity import QuantityError, quantity, split_quantity
from cosim.scenario.model import Reference, Value

NAME = r"[A-Za-z][A-Za-z0-9_]*"
MAX_RATE = 10**7
MAX_SECONDS = 10**7
MAX_SAMPLES = 10**6


@dataclass(frozen=True, slots=True)
class Lag:
    """A delay as written: whole samples, whole base ticks, or a time (s)."""

    amount: Fraction
    unit: Literal["samples", "ticks", "s"]


def is_name(text: str) -> bool:
    """Whether components, channels, stations and rates may be called so."""
    return re.fullmatch(NAME, text) is not None


def _number(value: Any, unit: str, example: str) -> Fraction:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise problem(f"{describe(value)} is no {example}.")
    try:
        return quantity(value, unit)
    except QuantityError as error:
        raise problem(f"{error} Write a {example}.") from None


def _to_seconds(value: Any) -> Fraction:
    number = _number(value, "s", "time, such as 10, '2.44 ms' or '2 min'")
    if not 0 < number <= MAX_SECONDS:
        raise problem(f"{value} is out of range: more than 0 s and at most {MAX_SECONDS} s.")
    return number


def _to_span(value: Any) -> Fraction:
    number = _number(value, "s", "time, such as 0, '0.49 ms'")
    if not 0 <= number <= MAX_SECONDS:
        raise problem(f"{value} is out of range: at least 0 s and at most {MAX_SECONDS} s.")
    return number


def _to_shift(value: Any) -> Fraction:
    number = _number(value, "s", "time, such as 0.5, '-12 s'")
    if not abs(number) <= MAX_SECONDS:
        raise problem(f"{value} is out of range: at most {MAX_SECONDS} s either way.")
    return number


def _to_hertz(value: Any) -> Fraction:
    number = _number(value, "Hz", "rate, such as 1024, '128 Hz' or '8192/3 Hz'")
    if not 0 < number <= MAX_RATE:
        raise problem(f"{value} is out of range: more than 0 Hz and at most {MAX_RATE} Hz.")
    return number


def _to_rate(value: Any) -> Fraction | str:
    return value if isinstance(value, str) and is_name(value) else _to_hertz(value)


def to_lag(value: Any) -> Lag:
    """A delay as written: whole samples, whole base ticks, or a time."""
    text = value if isinstance(value, str) else None
    try:
        number, unit = split_quantity(text) if text is not None else (None, None)
    except QuantityError:
        number, unit = None, None
    if unit in {"tick", "ticks", "sample", "samples"} and number is not None:
        lag = Lag(number, "ticks" if unit.startswith("tick") else "samples")
    elif text is not None:
        seconds = _number(value, "s", "delay, such as 1 (samples), '2 ticks' or '2.44 ms'")
        lag = Lag(seconds, "samples" if unit is None else "s")
    else:
        lag = Lag(_number(value, "1", "delay, such as 1 (samples) or '2.44 ms'"), "samples")
    if lag.unit != "s" and lag.amount.denominator != 1:
        raise problem(
            f"{value} is not a whole number of {lag.unit}; write a time, such as '2.44 ms', and it "
            "is rounded up to base ticks."
        )
    most = MAX_SECONDS if lag.unit == "s" else MAX_SAMPLES
    if not 0 <= lag.amount <= most:
        raise problem(f"{value} is out of range: a delay is at least 0 and at most {most}.")
    return lag


def to_instant(value: Any) -> Lag:
    """A time since the start as written: seconds, or whole base ticks."""
    try:
        unit = split_quantity(value)[1] if isinstance(value, str) else None
    except QuantityError:
        unit = None
    if unit in {"tick", "ticks"}:
        return to_lag(value)
    seconds = _number(value, "s", "time, such as 2 (seconds), '250 ms' or '64 ticks'")
    if not 0 <= seconds <= MAX_SECONDS:
        raise problem(f"{value} is out of range: at least 0 s and at most {MAX_SECONDS} s.")
    return Lag(seconds, "s")


def _to_packet(value: Any) -> Lag | None:
    return None if value == "lost" else to_lag(value)


def to_probability(value: Any) -> float:
    """A probability as written: a number from 0 to 1, or a percentage."""
    number = _number(value, "1", "probability from 0 to 1, such as 0.2 or '20 %'")
    if not 0 <= number <= 1:
        raise problem(f"{value} is not a probability: it is from 0 to 1 ('20 %' is 0.2).")
    return float(number)


def _to_name(value: Any) -> str:
    if isinstance(value, str) and is_name(value):
        return value
    raise problem(f"{describe(value)} is no name: letters, digits and '_', a letter first.")


def _to_reference(value: Any) -> Reference:
    component, dot, path = value.partition(".") if isinstance(value, str) else ("", "", "")
    if not dot or not path or not is_name(component):
        raise problem(f"{describe(value)} is no signal; write component.variable.")
    return Reference(component=component, path=path)


def _to_pattern(value: Any) -> str:
    if not isinstance(value, str) or not value.strip():
        raise problem(f"{describe(value)} is no pattern; write 'component.variable' or 'vr_?.*'.")
    return value.strip()


def _to_value(value: Any) -> Value:
    if isinstance(value, list):
        return tuple(_to_value(item) for item in cast("list[Any]", value))
    if isinstance(value, float) and not math.isfinite(value):
        raise problem(f"a parameter is a finite number; it cannot be {describe(value)}.")
    if not isinstance(value, bool | int | float | str):
        raise problem(
            f"{describe(value)} is no value; write a number, text, true, false or a list."
        )
    return value


_QUANTITY = r"^\s*[+-]?[0-9.]+([eE][+-]?[0-9]+)?(\s*/\s*[0-9]+)?\s*"


def _schema(*forms: dict[str, Any], description: str) -> WithJsonSchema:
    return WithJsonSchema({"anyOf": list(forms), "description": description})


def _text(units: str) -> dict[str, Any]:
    return {"type": "string", "pattern": f"{_QUANTITY}{units}\\s*$"}


_POSITIVE = {"type": "number", "exclusiveMinimum": 0}
_PLAIN_NAME = {"type": "string", "pattern": f"^{NAME}$"}
_SECONDS = r"(n|u|µ|μ|m)?s|min|h"
_COUNT = {"type": "integer", "minimum": 0, "maximum": MAX_SAMPLES}
_LAG = _text(f"(samples?|ticks?|{_SECONDS})?")


def _plain(function: Callable[[Any], Any]) -> PlainValidator:
    return PlainValidator(function)


Seconds = Annotated[
    Fraction,
    _plain(_to_seconds),
    _schema(_POSITIVE, _text(f"({_SECONDS})?"), description="A time: seconds, or with a unit."),
]
Span = Annotated[
    Fraction,
    _plain(_to_span),
    _schema(
        {"type": "number", "minimum": 0},
        _text(f"({_SECONDS})?"),
        description="A time of 0 or more: seconds, or with a unit.",
    ),
]
Shift = Annotated[
    Fraction,
    _plain(_to_shift),
    _schema(
        {"type": "number"},
        _text(f"({_SECONDS})?"),
        description="A time of either sign: seconds, or with a unit.",
    ),
]
Hertz = Annotated[
    Fraction,
    _plain(_to_hertz),
    _schema(_POSITIVE, _text("(m|k|M)?(Hz)?"), description="A rate: hertz, or with a unit."),
]
Rate = Annotated[
    Fraction | str,
    _plain(_to_rate),
    _schema(
        _PLAIN_NAME,
        _POSITIVE,
        _text("(m|k|M)?(Hz)?"),
        description="The name of a rate, or a rate in hertz.",
    ),
]
Delay = Annotated[
    Lag,
    _plain(to_lag),
    _schema(_COUNT, _LAG, description="Whole samples (a number), '2 ticks', or a time."),
]
Instant = Annotated[
    Lag,
    _plain(to_instant),
    _schema(
        {"type": "number", "minimum": 0},
        _text(f"(ticks?|{_SECONDS})?"),
        description="The model's time: seconds, or with a unit; or '64 ticks' since the start.",
    ),
]
Packet = Annotated[
    Lag | None,
    _plain(_to_packet),
    _schema({"const": "lost"}, _COUNT, _LAG, description="A packet's delay, or 'lost'."),
]
Probability = Annotated[
    float,
    _plain(to_probability),
    _schema(
        {"type": "number", "minimum": 0, "maximum": 1},
        _text("%?"),
        description="A probability from 0 to 1, or in percent.",
    ),
]
Name = Annotated[str, _plain(_to_name), WithJsonSchema(_PLAIN_NAME)]
Signal = Annotated[
    Reference,
    _plain(_to_reference),
    WithJsonSchema({"type": "string", "pattern": f"^{NAME}\\..+$"}),
]
SignalName = Annotated[
    str,
    _plain(lambda value: str(_to_reference(value))),
    WithJsonSchema({"type": "string", "pattern": f"^{NAME}\\..+$"}),
]
Pattern = Annotated[str, _plain(_to_pattern), WithJsonSchema({"type": "string", "minLength": 1})]
Given = Annotated[
    Value,
    _plain(_to_value),
    WithJsonSchema({"type": ["number", "boolean", "string", "array", "object"]}),
]
