"""Problems of one document, collected and reported together, each a sentence with its place."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from contextlib import contextmanager
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from cosim.base.errors import InputError, InputErrors, Location
from cosim.base.node import Node, PathKey
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

    def __bool__(self) -> bool:
        return bool(self._errors)

    def add(self, path: tuple[PathKey, ...], message: str, *, at_key: bool = False) -> None:
        """Report a problem with the node at ``path``, pointing at its key on request."""
        node, _ = self._root.find(path)
        self.add_at((at_key and node.key_place) or node.place, message)

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
            hint = did_you_mean(str(path[-1]), known_keys(self._form, error["loc"]))
            self.add_at(node.key_place or node.place, f"unknown key '{path[-1]}'{inside}.{hint}")
        elif kind == "missing":
            self.add_at(node.place, f"{where} needs '{error['loc'][-1]}'.")
        elif node.value is None and path:
            self.add_at(node.key_place or node.place, f"{where}: it has no value.")
        elif kind == "sentence":
            at_key = error["loc"][-1:] == ("[key]",) or isinstance(node.value, dict)
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


def describe(value: Any) -> str:
    """A value as it is named in a message: ``the text 'abc'``, ``a list``."""
    match value:
        case None:
            return "nothing"
        case bool():
            return "true" if value else "false"
        case str():
            return f"the text '{value if len(value) <= 60 else value[:57] + '...'}'"
        case dict():
            return "a mapping"
        case list():
            return "a list"
        case _:
            return f"{value}"[:60]


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


def known_keys(form: Any, loc: tuple[PathKey, ...]) -> list[str]:
    """The keys that the form has where ``loc`` has one too many."""
    reached = [form]
    for key in loc[:-1]:
        reached = [inner for kind in reached for inner in _members(kind, key)]
    forms = [inner for kind in reached for inner in _alternatives(kind) if _fields(inner)]
    return list(dict.fromkeys(key for form in forms for key in _written(form)))


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
    return []
