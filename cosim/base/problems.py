"""Problems of one document, collected and reported together, each a sentence with its place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cosim.base.errors import InputError, InputErrors, Location
from cosim.base.node import Node, PathKey
from cosim.base.suggest import did_you_mean


class Problems:
    """Collects errors while the rest of the document is still looked at."""

    def __init__(self, root: Node) -> None:
        self._root = root
        self._errors: list[InputError] = []

    def __bool__(self) -> bool:
        return bool(self._errors)

    def add(self, path: tuple[PathKey, ...], message: str, *, at_key: bool = False) -> None:
        """Report a problem with the node at ``path``, pointing at its key on request."""
        node, _ = self._root.find(path)
        self.add_at((at_key and node.key_place) or node.place, message)

    def add_at(self, place: Location, message: str) -> None:
        """Report a problem with a place."""
        error = InputError(message, place)
        if all(str(error) != str(other) for other in self._errors):
            self._errors.append(error)

    def raise_if_any(self) -> None:
        """Raise what was collected.

        Raises:
            InputError: one problem, or ``InputErrors`` with several.
        """
        if len(self._errors) == 1:
            raise self._errors[0]
        if self._errors:
            raise InputErrors(self._errors)

    def add_validation(self, error: Mapping[str, Any]) -> None:
        """Report one of pydantic's findings."""
        path, node = self._document_path(error["loc"])
        where = _dotted(path)
        kind, context = error["type"], error.get("ctx", {})
        if kind == "extra_forbidden":
            inside = f" in {_dotted(path[:-1])}" if path[:-1] else ""
            hint = did_you_mean(str(path[-1]), _keys_at(error["loc"]))
            self.add_at(node.key_place or node.place, f"unknown key '{path[-1]}'{inside}.{hint}")
        elif kind == "missing":
            self.add_at(node.place, f"{where or 'the scenario'} needs '{error['loc'][-1]}'.")
        elif node.value is None:
            self.add_at(node.key_place or node.place, f"{where}: it has no value.")
        elif kind == "sentence":
            at_key = error["loc"][-1] == "[key]" or isinstance(node.value, dict)
            self.add_at((at_key and node.key_place) or node.place, f"{where}: {error['msg']}")
        else:
            sentence = _sentence(kind, error["input"], context) or f"{error['msg']}."
            self.add_at(node.place, f"{where}: {sentence}")

    def _document_path(self, loc: tuple[PathKey, ...]) -> tuple[tuple[PathKey, ...], Node]:
        """The part of pydantic's path that is in the document: union tags are not."""
        node, path = self._root, ()
        for key in loc:
            found = node.child(key)
            if found is not None:
                node, path = found, (*path, key)
        return path, node


def _dotted(path: tuple[PathKey, ...]) -> str:
    return ".".join(map(str, path))


def _sentence(kind: str, value: Any, context: Mapping[str, Any]) -> str | None:
    from cosim.scenario.form.fields import describe

    wanted = {
        "string_type": "a text",
        "int_type": "a whole number",
        "int_from_float": "a whole number",
        "float_type": "a number",
        "bool_type": "true or false",
        "dict_type": "a mapping ('key: value' lines)",
        "model_type": "a mapping ('key: value' lines)",
        "model_attributes_type": "a mapping ('key: value' lines)",
        "list_type": "a list",
    }
    if kind in wanted:
        return f"this must be {wanted[kind]}, not {describe(value)}."
    if kind == "literal_error":
        choices = context["expected"].replace("'", "").replace(" or ", ", ").split(", ")
        hint = did_you_mean(str(value), choices, listed=0)
        return f"this must be {context['expected']}, not {describe(value)}.{hint}"
    limits = {
        "greater_than_equal": f"at least {context.get('ge')}",
        "less_than_equal": f"at most {context.get('le')}",
        "less_than": f"less than {context.get('lt')}",
    }
    if kind in limits:
        return f"this must be {limits[kind]}, not {describe(value)}."
    if kind in {"too_short", "too_long"}:
        bound = "at least" if kind == "too_short" else "at most"
        length = context.get("min_length", context.get("max_length"))
        return f"this list must have {bound} {length} items, not {context.get('actual_length')}."
    return None


def _keys_at(loc: tuple[PathKey, ...]) -> list[str]:
    """The keys that are known where ``loc`` has one too many."""
    from cosim.scenario.form.channel import (
        Both,
        ChannelForm,
        DelayBoth,
        GilbertElliottForm,
        LateForm,
        RmsJitter,
        WeightedJitter,
    )
    from cosim.scenario.form.document import ComponentForm, ConnectionForm, Document, RecordForm

    section, inner = loc[0], loc[2:-1]
    if len(loc) == 1:
        form: Any = Document
    elif section == "channels" and inner:
        by_tag: dict[PathKey, Any] = {"rms": RmsJitter, "weights": WeightedJitter, "both": Both}
        by_tag["mapping"] = GilbertElliottForm if inner[0] == "loss" else LateForm
        by_tag["delay"] = DelayBoth
        form = by_tag.get(inner[-1], ChannelForm)
    else:
        forms = {"components": ComponentForm, "channels": ChannelForm}
        forms |= {"connections": ConnectionForm, "record": RecordForm}
        form = forms.get(str(section), Document)
    keys = [field.alias or name for name, field in form.model_fields.items()]
    return [*keys, "include"] if form in {Document, ComponentForm, ChannelForm} else keys
