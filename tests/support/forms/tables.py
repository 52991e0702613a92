"""Tables of keys in the documentation, written from the forms that read them.

``python -m tests.support.forms.tables`` writes them anew between their markers.
"""

from __future__ import annotations

import re
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel

from cosim.base.document.form import QuantityIn
from cosim.reading import FORMS
from hil.emulation.mechanics import Mechanics
from hil.sensing.sensor_file import SensorFileForm
from hil.setup.device_form import DeviceFileForm
from hil.setup.options import IntegersIn
from hil.setup.registry import find, names
from tests.support.forms.walk import forms_in

DOCS = Path(__file__).parents[3] / "docs"
MARK = re.compile(
    r"(<!-- keys of (\w+)( with defaults)? -->\n)(.*?)(<!-- end of keys -->)", re.DOTALL
)


def forms() -> dict[str, type[BaseModel]]:
    """Every form that may have a table, by name."""
    drivers = [find(name) for name in names()]
    roots = [
        DeviceFileForm,
        SensorFileForm,
        Mechanics,
        *(FORMS[name]() for name in ("safety", "realtime", "link")),
        *(driver.settings for driver in drivers),
        *(driver.options for driver in drivers),
    ]
    return {form.__name__: form for form in forms_in(*roots)}


def written(text: str) -> str:
    """A page with its tables as the forms have them."""
    known = forms()

    def renewed(mark: re.Match[str]) -> str:
        keys = table(known[mark[2]], with_defaults=mark[3] is not None)
        return f"{mark[1]}\n{keys}\n{mark[5]}"

    return MARK.sub(renewed, text)


def table(form: type[BaseModel], *, with_defaults: bool = False) -> str:
    """The keys of a form, what they take, and what they mean."""
    columns = ["key", "takes", *(["default"] if with_defaults else []), "meaning"]
    lines = [f"| {' | '.join(columns)} |", "|---" * len(columns) + "|"]
    for name, field in form.model_fields.items():
        takes = _takes(field.annotation, field.metadata) or "a mapping"
        cells = [f"`{field.alias or name}`", takes]
        cells += [_default(field.default)] if with_defaults else []
        lines.append(f"| {' | '.join([*cells, field.description or ''])} |")
    return "\n".join(lines) + "\n"


def _default(value: Any) -> str:
    """A default as it would be written; nothing where there is none."""
    if value is None or not isinstance(value, bool | int | float | str):
        return ""
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


def _takes(kind: Any, notes: Any = ()) -> str:
    for note in notes:
        if isinstance(note, QuantityIn):
            return _range(note)
        if isinstance(note, IntegersIn):
            return note.what
        if "enum" in (getattr(note, "json_schema", None) or {}):
            return " or ".join(f"`{value}`" for value in note.json_schema["enum"])
    if get_origin(kind) is Annotated:
        inner, *more = get_args(kind)
        return _takes(inner, more)
    if get_origin(kind) in {Union, UnionType}:
        found = [_takes(member) for member in get_args(kind) if member is not type(None)]
        return " or ".join(dict.fromkeys(filter(None, found)))
    if get_origin(kind) is Literal:
        return " or ".join(f"`{value}`" for value in get_args(kind))
    if get_origin(kind) is list:
        return f"two of: {_takes(get_args(kind)[0]) or 'a mapping'}"
    return {bool: "`true` or `false`", str: "text"}.get(kind, "")


def _range(note: QuantityIn) -> str:
    unit = "" if note.unit == "1" else f" {note.unit}"
    bounds = [
        f"{word} {bound:g}{unit}"
        for word, bound in (("more than", note.above), ("from", note.least), ("to", note.most))
        if bound is not None and abs(bound) < 1e8
    ]
    kind = "a whole number" if note.whole else "a number"
    return " ".join([kind if unit == "" else f"{kind} in{unit}", *bounds])


if __name__ == "__main__":
    for page in DOCS.glob("*.md"):
        before = page.read_text("utf-8")
        page.write_text(written(before), "utf-8")
