"""Problems of one document, collected and reported together, each a sentence with its place."""

from __future__ import annotations

import re
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from cosim.base.document.node import Node, PathKey
from cosim.base.document.show import describe, truth_hint
from cosim.base.document.typography import odd_characters
from cosim.base.errors import InputError, InputErrors, Location
from cosim.base.suggest import did_you_mean


class Problems:
    """Collects errors while the rest of the document is still looked at."""

    def __init__(self, root: Node, form: Any = None, subject: str = "the document") -> None:
        """``form`` is what ``root`` is read into, for the keys that it could have had."""
        self._root = root
        self._form = form
        self._subject = subject
        self._errors: list[InputError] = []
        self._ignored: tuple[type[InputError], ...] = ()

    def of(self, form: Any) -> Problems:
        """The same problems, now that the form is known."""
        found = Problems(self._root, form, self._subject)
        found._errors = self._errors
        return found

    def __bool__(self) -> bool:
        return bool(self._errors)

    def add(self, path: tuple[PathKey, ...], message: str, *, at_key: bool = False) -> None:
        """Report a problem with the node at ``path``, pointing at its key on request."""
        node, _ = self._root.find(path)
        written = path[-1] if at_key and isinstance(path[-1], str) else node.value
        self.add_at((at_key and node.key_place) or node.place, _with_oddities(message, written))

    def add_at(self, place: Location, message: str) -> None:
        """Report a problem with a place."""
        self._note(InputError(message, place))

    def _note(self, error: InputError) -> None:
        if all(str(error) != str(other) for other in self._errors):
            self._errors.append(error)

    def ignore(self, kind: type[InputError]) -> None:
        """Errors of this kind only follow from one that was reported."""
        self._ignored = (*self._ignored, kind)

    @contextmanager
    def at(self, path: tuple[PathKey, ...]) -> Generator[None]:
        """Collect an error raised inside, with the place of ``path`` unless it brings its own."""
        try:
            yield
        except self._ignored:
            pass
        except InputErrors as several:
            for error in several.errors:
                self._note(error)
        except InputError as error:
            self._note(InputError(error.message, error.location or self._root.locate(path)))

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
        where = _dotted(path) or self._subject
        kind, context = error["type"], error.get("ctx", {})
        if kind == "extra_forbidden":
            inside = f" in {_dotted(path[:-1])}" if path[:-1] else ""
            hint = self._key_hint(str(path[-1]), error["loc"])
            message = _with_oddities(f"unknown key '{path[-1]}'{inside}.{hint}", path[-1])
            self.add_at(node.key_place or node.place, message)
        elif kind == "missing":
            self.add_at(node.place, f"{where} needs '{error['loc'][-1]}'.")
        elif node.value is None and path:
            self.add_at(node.key_place or node.place, f"{where}: it has no value.")
        elif kind == "sentence":
            at_key = error["loc"][-1:] == ("[key]",) or isinstance(node.value, dict)
            message = _with_oddities(f"{where}: {error['msg']}", error["input"])
            self.add_at((at_key and node.key_place) or node.place, message)
        else:
            sentence = _sentence(kind, error["input"], context) or f"{error['msg']}."
            self.add_at(node.place, f"{where}: {sentence}")

    def _key_hint(self, key: str, loc: tuple[PathKey, ...]) -> str:
        hint = did_you_mean(key, known_keys(self._form, loc))
        inner = next(
            (
                form.unknown_in
                for form in forms_at(self._form, loc[:-1])
                if hasattr(form, "unknown_in")
            ),
            "",
        )
        return hint if hint or not inner else f" Did you mean {inner}.{key}?"

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
        return f"this must be {wanted[kind]}, not {describe(value)}{_instead(wanted[kind], value)}."
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


def _instead(wanted: str, value: Any) -> str:
    """What to write where another kind of value is due."""
    if wanted == "true or false":
        return truth_hint(value)
    if wanted == "a list" and isinstance(value, str):
        dash = re.match(r"-(?=\S)", value)
        return f"; write '- {value[1:20]}', with a space" if dash else f"; write [{value[:30]}]"
    if "mapping" in wanted and isinstance(value, list):
        return "; take the '-' or the brackets away"
    return ""


def independent(findings: Sequence[Any]) -> list[Any]:
    """Pydantic's findings without those that only follow from another.

    A key that is missing where a similar one is unknown was misspelt: that is one mistake.
    """
    unknown = [error["loc"] for error in findings if error["type"] == "extra_forbidden"]
    return [
        error
        for error in findings
        if error["type"] != "missing"
        or not any(
            loc[:-1] == error["loc"][:-1]
            and did_you_mean(str(loc[-1]), [str(error["loc"][-1])], listed=0)
            for loc in unknown
        )
    ]


def _with_oddities(message: str, written: Any) -> str:
    hint = odd_characters(written) if isinstance(written, str) else ""
    return message if hint in message else message + hint


def known_keys(form: Any, loc: tuple[PathKey, ...]) -> list[str]:
    """The keys that the form has where ``loc`` has one too many."""
    forms = forms_at(form, loc[:-1])
    return list(dict.fromkeys(key for form in forms for key in _written(form)))


def forms_at(form: Any, loc: tuple[PathKey, ...]) -> list[Any]:
    """The forms that a member at pydantic's path ``loc`` of ``form`` may have."""
    reached = [form]
    for key in loc:
        reached = [inner for kind in reached for inner in _members(kind, key)]
    return [inner for kind in reached for inner in _alternatives(kind) if _fields(inner)]


def _written(form: Any) -> list[str]:
    """A form's keys as they are written, with those that the reader takes away before."""
    return [
        *(field.alias or name for name, field in _fields(form).items()),
        *getattr(form, "read_before", ()),
    ]


def _fields(kind: Any) -> Mapping[str, Any]:
    return getattr(kind, "model_fields", {})


def _alternatives(kind: Any) -> list[Any]:
    """The types that a type stands for: members of a union, without their annotations."""
    origin = get_origin(kind)
    if origin is Annotated:
        return _alternatives(get_args(kind)[0])
    if origin in {Union, UnionType}:
        return [inner for member in get_args(kind) for inner in _alternatives(member)]
    return [kind]


def _members(kind: Any, key: PathKey) -> list[Any]:
    """What a type has under a key of pydantic's path; a union's tag leads into its member."""
    origin = get_origin(kind)
    if origin is Annotated:
        inner, *notes = get_args(kind)
        if any(getattr(note, "tag", None) == key for note in notes):
            return [inner]
        return _members(inner, key)
    if origin in {Union, UnionType}:
        return [found for member in get_args(kind) for found in _members(member, key)]
    if origin in {dict, list, tuple}:
        return [get_args(kind)[-1] if origin is dict else get_args(kind)[0]]
    for name, field in _fields(kind).items():
        if key == (field.alias or name):
            return [field.annotation]
    other = getattr(kind, "any_other", None)
    return [] if other is None else [other]
