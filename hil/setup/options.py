"""Options in a device's URL: a form that stands with what obeys them, each value read from text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeVar, cast

from pydantic import Field
from pydantic_core import CoreSchema, core_schema

from cosim.base.document.form import Form, plain_node, problem, read_form
from cosim.base.document.show import describe
from cosim.base.errors import Location
from hil.setup.address import DeviceAddress


class UrlOptions(Form):
    """Options that every device has; base of each driver's."""

    emulator: str | None = Field(default=None, description="Side channel of an emulator.")
    lockstep: Literal["0", "1"] = Field(
        default="0", description="1: the emulator advances only as the driver exchanges."
    )


F = TypeVar("F", bound=Form)


def read_options(form: type[F], address: DeviceAddress) -> F:
    """Those of a URL's options that ``form`` has.

    Raises:
        InputError: one of them cannot be.
    """
    known = {name: text for name, text in address.options.items() if name in form.model_fields}
    return _read(form, address, known)


def check_options(form: type[Form], address: DeviceAddress) -> None:
    """Refuse an option that the driver does not have, or a value that cannot be.

    Raises:
        InputError: all of them.
    """
    _read(form, address, address.options)


def _read(form: type[F], address: DeviceAddress, options: Any) -> F:
    place = Location(f"the device URL {address.url}", 0, 0)
    return read_form(form, plain_node(options, place), "a device URL")


@dataclass(frozen=True, slots=True, kw_only=True)
class IntegersIn:
    """Annotates a short tuple of different whole numbers: a list, or a text such as ``0,1``.

    ``counts`` are the numbers of them there may be; ``what`` completes the sentence "… has to be".
    """

    counts: tuple[int, ...] = (2,)
    least: int
    most: int
    what: str
    different: bool = True

    def read(self, value: Any) -> tuple[int, ...]:
        """The numbers.

        Raises:
            PydanticCustomError: there are others, too many or too few of them, or one twice.
        """
        found = self._integers(value)
        inside = all(self.least <= each <= self.most for each in found)
        if len(found) not in self.counts or not inside:
            shown = f"{cast('list[Any]', value)}" if isinstance(value, list) else describe(value)
            raise problem(f"this has to be {self.what}, not {shown}.")
        if self.different and len(set(found)) != len(found):
            raise problem(f"this has to be {self.what}; {list(found)} has one twice.")
        return found

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        """How pydantic reads the annotated type: by :meth:`read`."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: Any) -> dict[str, Any]:
        """What an editor is told of it."""
        item = {"type": "integer", "minimum": self.least, "maximum": self.most}
        bounds = {"minItems": min(self.counts), "maxItems": max(self.counts)}
        listed = {"type": "array", "items": item, **bounds}
        return {"anyOf": [listed, {"type": ["string", "integer"]}]}

    @staticmethod
    def _integers(value: Any) -> tuple[int, ...]:
        if isinstance(value, str):
            try:
                return tuple(int(item, 0) for item in value.split(","))
            except ValueError:
                return ()
        found = cast("list[Any]", value) if isinstance(value, list) else [value]
        return tuple(found) if all(type(each) is int for each in found) else ()
