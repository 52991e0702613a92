"""``expect:`` of a signal as it is written: a key for every measure and comparison, and windows.

Thresholds keep their text: their unit is the signal's, which is known once its variable is.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, ClassVar, cast

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PlainValidator,
    WithJsonSchema,
    create_model,
    model_validator,
)

from cosim.base.document.form import Form, problem
from cosim.base.document.show import describe, show
from cosim.base.quantities.quantity import QuantityError, exact, quantity, split_quantity
from cosim.base.suggest import did_you_mean

COMPARISONS = ("below", "above", "within", "equals")
"""``within`` takes ``[low, high]``, the others one number."""


def _number(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise problem(f"this takes one number, not {show(value)}.")
    try:
        split_quantity(value) if isinstance(value, str) else exact(value)
    except QuantityError as error:
        raise problem(str(error)) from None
    return value


def _pair(value: Any) -> Any:
    items = cast("list[Any]", value) if isinstance(value, list) else []
    if len(items) != 2:
        raise problem(f"this takes [low, high], not {show(value)}.")
    return [_number(item) for item in items]


def _time(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise problem(f"{describe(value)} is no time, such as 2 or '500 ms'.")
    try:
        quantity(value, "s")
    except QuantityError as error:
        raise problem(f"{error} Write a time, such as 2 or '500 ms'.") from None
    return value


def _frequency(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise problem(f"frequency is a number in rad/s, not {show(value)}.")
    return value


_ONE: dict[str, Any] = {"type": ["number", "string"]}
Threshold = Annotated[Any, PlainValidator(_number), WithJsonSchema(_ONE)]
Range = Annotated[
    Any,
    PlainValidator(_pair),
    WithJsonSchema({"type": "array", "items": _ONE, "minItems": 2, "maxItems": 2}),
]
Time = Annotated[Any, PlainValidator(_time), WithJsonSchema(_ONE)]
Frequency = Annotated[Any, PlainValidator(_frequency), WithJsonSchema({"type": "number"})]


class WindowForm(Form):
    """What holds in a window of time; without `from` and `to` it is the whole run."""

    start: Time | None = Field(default=None, alias="from", description="Begin of the window (s).")
    to: Time | None = Field(default=None, description="End of the window, included (s).")
    frequency: Frequency | None = Field(default=None, description="Of an amplitude (rad/s).")


@cache
def expect_form() -> type[BaseModel]:
    """Conditions of a signal, and named windows with conditions of their own."""
    from cosim.report.window import MEASURES

    keys: dict[str, Any] = {}
    for measure in ("", *MEASURES):
        for comparison in COMPARISONS:
            name = f"{measure}_{comparison}".removeprefix("_")
            kind: Any = Range if comparison == "within" else Threshold
            said = f"{measure or 'every value'} {comparison} this"
            keys[name] = (kind | None, Field(default=None, description=said))
    window = create_model("WindowForm", __base__=WindowForm, __doc__=WindowForm.__doc__, **keys)
    known = [field.alias or name for name, field in window.model_fields.items()]

    class ExpectForm(window):  # pyright: ignore[reportGeneralTypeIssues]
        """Conditions of a signal or a measure, or named windows with conditions."""

        model_config = ConfigDict(extra="allow")
        any_other: ClassVar[Any] = window
        __pydantic_extra__: dict[str, window]  # pyright: ignore[reportInvalidTypeForm, reportIncompatibleVariableOverride]

        @model_validator(mode="before")
        @classmethod
        def _only_windows_have_names(cls, value: Any) -> Any:
            members = cast("dict[str, Any]", value) if isinstance(value, dict) else {}
            odd = [
                key
                for key, inner in members.items()
                if key not in known and not isinstance(inner, dict)
            ]
            if odd:
                what = "is not a predicate" if len(odd) == 1 else "are not predicates"
                raise problem(f"{', '.join(odd)} {what}.{did_you_mean(odd[0], known)}")
            return cast("Any", value)

    return ExpectForm
