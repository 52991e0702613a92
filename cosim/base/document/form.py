"""What every form has in common: a pydantic model that a document is read into, and its errors.

A form stands in the package that obeys it. It knows its keys only, converts nothing silently, and
takes quantities with their units; ``read_form`` turns a tree of nodes into one, or raises every
problem at once, each with its place.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from typing import Any, ClassVar, TypeVar, cast

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from cosim.base.document.node import Node, PathKey
from cosim.base.document.problems import Problems, independent
from cosim.base.document.show import describe
from cosim.base.errors import Location
from cosim.base.quantities.quantity import QuantityError, quantity

_PLUGINS = "PYDANTIC_DISABLE_PLUGINS"
_TEXT = r"^\s*[+-]?[0-9.]+([eE][+-]?[0-9]+)?(\s*/\s*[0-9]+)?\s*"


class Form(BaseModel):
    """What every part of a document has in common: known keys only, no silent conversion."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, defer_build=True)
    read_before: ClassVar[tuple[str, ...]] = ()
    """Keys that a form may have in a file, but that its reader has dealt with already."""
    unknown_in: ClassVar[str] = ""
    """The member that an unknown key is likely to belong into."""
    any_other: ClassVar[Any] = None
    """What keys of the user's own choice lead to, in a form that takes them."""


F = TypeVar("F", bound=BaseModel)


def ready(form: type[BaseModel]) -> None:
    """Build what judges a form, which is put off until there is a document for it.

    Pydantic would look for plugins of its own in every installed package first; a form has none.
    """
    if form.__pydantic_complete__:
        return
    chosen = os.environ.get(_PLUGINS)
    os.environ[_PLUGINS] = "__all__"
    try:
        form.model_rebuild()
    finally:
        if chosen is None:
            del os.environ[_PLUGINS]
        else:
            os.environ[_PLUGINS] = chosen


def problem(sentence: str) -> PydanticCustomError:
    """An error whose text is already the sentence to show."""
    return PydanticCustomError("sentence", "{sentence}", {"sentence": sentence})


def mapping_tag(value: Any) -> str:
    """Whether a value is written as a mapping or plainly; tells the members of a union apart."""
    return "mapping" if isinstance(value, dict) else "plain"


def plain_node(value: Any, place: Location) -> Node:
    """A tree of nodes for plain data that comes from no file; ``place`` is said in messages."""
    if isinstance(value, Mapping):
        members = cast("Mapping[Any, Any]", value)
        return Node({str(k): plain_node(member, place) for k, member in members.items()}, place)
    if isinstance(value, list | tuple):
        items = cast("Sequence[Any]", value)
        return Node([plain_node(item, place) for item in items], place)
    return Node(value.isoformat() if isinstance(value, date) else value, place)


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
    ready(form)
    try:
        return form.model_validate(node.plain())
    except ValidationError as error:
        for finding in independent(error.errors(include_url=False)):
            problems.add_validation({**finding, "loc": (*path, *finding["loc"])})
        return None


@dataclass(frozen=True, slots=True, kw_only=True)
class QuantityIn:
    """Annotates a number of a form: one in ``unit``, or a text with any unit that converts to it.

    ``Annotated[float, QuantityIn(unit="m", what="length, such as 0.1 or '100 mm'", above=0)]``. It
    is read exactly and rounded once, to a double in ``unit``; ``whole`` asks for an integer.
    ``what`` completes the sentence "… is no".
    """

    unit: str
    what: str
    above: float | None = None
    least: float | None = None
    most: float | None = None
    whole: bool = False

    def read(self, value: Any) -> float:
        """The number that was written.

        Raises:
            PydanticCustomError: it is none, of another dimension, out of range or not whole.
        """
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise problem(f"{describe(value)} is no {self.what}.")
        try:
            exact = quantity(value if isinstance(value, int | str) else float(value), self.unit)
            found = float(exact)
        except QuantityError as error:
            raise problem(f"{error} Write a {self.what}.") from None
        except OverflowError:
            raise problem(f"{describe(value)} is out of range for a {self.what}.") from None
        low = self.above is not None and found <= self.above
        low = low or (self.least is not None and found < self.least)
        if low or (self.most is not None and found > self.most):
            raise problem(f"{describe(value)} is out of range: {self._range()}.")
        if self.whole and exact.denominator != 1:
            raise problem(f"{describe(value)} is not whole; write a {self.what}.")
        return int(exact) if self.whole else found

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        """How pydantic reads the annotated type: by :meth:`read`."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: Any) -> dict[str, Any]:
        """What an editor is told of it."""
        plain: dict[str, Any] = {"type": "integer" if self.whole else "number"}
        bounds = {"exclusiveMinimum": self.above, "minimum": self.least, "maximum": self.most}
        plain |= {name: bound for name, bound in bounds.items() if bound is not None}
        return {"anyOf": [plain, {"type": "string", "pattern": _TEXT}]}

    def _range(self) -> str:
        name = "" if self.unit == "1" else f" {self.unit}"
        bounds = (("more than", self.above), ("at least", self.least), ("at most", self.most))
        return " and ".join(f"{word} {b:g}{name}" for word, b in bounds if b is not None)
