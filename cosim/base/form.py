"""What every form has in common: a pydantic model that a document is read into, and its errors.

A form stands in the package that obeys it. It knows its keys only, converts nothing silently, and
takes quantities with their units; ``read_form`` turns a tree of nodes into one, or raises every
problem at once, each with its place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, TypeVar

from pydantic import BaseModel, ConfigDict, PlainValidator, ValidationError, WithJsonSchema
from pydantic_core import PydanticCustomError

from cosim.base.node import Node, PathKey
from cosim.base.problems import Problems, independent
from cosim.base.quantity import QuantityError, quantity
from cosim.base.show import describe

_TEXT = r"^\s*[+-]?[0-9.]+([eE][+-]?[0-9]+)?(\s*/\s*[0-9]+)?\s*"


class Form(BaseModel):
    """What every part of a document has in common: known keys only, no silent conversion."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)
    read_before: ClassVar[tuple[str, ...]] = ()
    """Keys that a form may have in a file, but that its reader has dealt with already."""
    unknown_in: ClassVar[str] = ""
    """The member that an unknown key is likely to belong into."""


F = TypeVar("F", bound=BaseModel)


def problem(sentence: str) -> PydanticCustomError:
    """An error whose text is already the sentence to show."""
    return PydanticCustomError("sentence", "{sentence}", {"sentence": sentence})


def read_form(form: type[F], node: Node, subject: str) -> F:
    """The document at ``node`` as a form; ``subject`` names the whole of it in messages.

    Raises:
        InputError: everything that is wrong with it.
    """
    problems = Problems(node, form, subject)
    found = check_form(form, node, problems)
    problems.raise_if_any()
    assert found is not None, "what is no form has a problem"
    return found


def check_form(
    form: type[F], node: Node, problems: Problems, path: Sequence[PathKey] = ()
) -> F | None:
    """``node``, which is at ``path`` of the whole document, as a form; ``None`` with problems."""
    try:
        return form.model_validate(node.plain())
    except ValidationError as error:
        for finding in independent(error.errors(include_url=False)):
            problems.add_validation({**finding, "loc": (*path, *finding["loc"])})
        return None


def number(
    unit: str,
    what: str,
    *,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
) -> Any:
    """The type of a quantity in a form: a number in ``unit``, or a text with any unit like it.

    Read exactly, and rounded once to a double in ``unit``. ``what`` completes "… is no": "length,
    such as 0.1 or '100 mm'".
    """

    def read(value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise problem(f"{describe(value)} is no {what}.")
        try:
            exact = quantity(value if isinstance(value, int | str) else float(value), unit)
            found = float(exact)
        except (QuantityError, OverflowError) as error:
            raise problem(f"{_sentence(error)} Write a {what}.") from None
        low = above is not None and found <= above
        if low or (least is not None and found < least) or (most is not None and found > most):
            raise problem(f"{describe(value)} is out of range: {_range(above, least, most, unit)}.")
        return found

    plain: dict[str, Any] = {"type": "number"}
    bounds = {"exclusiveMinimum": above, "minimum": least, "maximum": most}
    plain |= {name: bound for name, bound in bounds.items() if bound is not None}
    text = {"type": "string", "pattern": _TEXT}
    return Annotated[float, PlainValidator(read), WithJsonSchema({"anyOf": [plain, text]})]


def _sentence(error: Exception) -> str:
    return str(error) if isinstance(error, QuantityError) else "this number does not fit."


def _range(above: float | None, least: float | None, most: float | None, unit: str) -> str:
    name = "" if unit == "1" else f" {unit}"
    bounds = [
        f"{word} {_plain(bound)}{name}"
        for word, bound in (("more than", above), ("at least", least), ("at most", most))
        if bound is not None
    ]
    return " and ".join(bounds)


def _plain(bound: float) -> str:
    return f"{bound:g}" if math.isfinite(bound) else "any number"
