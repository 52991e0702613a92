"""Sections that others obey: each has a form in the package that does, handed to the reader.

The language knows that there are ``safety``, ``realtime``, ``link`` (of the scenario and of a
channel) and ``expect``; what may stand in them is said by whoever reads them. A reader that is
given no form for a section keeps it as it is written, and whoever obeys it judges it then.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pydantic import BaseModel

from cosim.base.document.node import Node

SECTIONS = ("safety", "realtime", "link", "expect")

Forms = Mapping[str, Callable[[], type[BaseModel]]]
"""What gives a section's form; called where the section is written, so that nothing else loads."""

Chosen = tuple[tuple[str, type[BaseModel]], ...]
"""Sections with their forms."""


def all_of(forms: Forms) -> Chosen:
    """Every form, for the schema."""
    return tuple((name, forms[name]()) for name in SECTIONS if name in forms)


def written_in(root: Node, forms: Forms) -> Chosen:
    """The forms of those sections that a document has."""
    channels = root.child("channels")
    inner = channels.value if channels is not None and isinstance(channels.value, dict) else {}
    written = {name for name in SECTIONS if root.child(name) is not None}
    if any(channel.child("link") is not None for channel in inner.values()):
        written.add("link")
    return tuple((name, forms[name]()) for name in SECTIONS if name in written and name in forms)


def plain(value: Any) -> dict[str, Any]:
    """A section as plain data in SI units, without what was not written."""
    if isinstance(value, BaseModel):
        return value.model_dump(by_alias=True, exclude_unset=True, exclude_none=True)
    return dict(value)
