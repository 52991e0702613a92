"""``include:`` — fragments that lie under the mapping which names them, at any depth."""

from __future__ import annotations

from os import PathLike, fspath
from pathlib import Path

from cosim.base.document.node import Node, PathKey
from cosim.base.document.show import show
from cosim.base.document.yaml_reader import read_yaml
from cosim.base.errors import InputError, Location
from cosim.base.suggest import did_you_mean
from cosim.scenario.source.find import bundled_folder, find_file, folder_of, shown_name
from cosim.scenario.source.merge import merge, normalise

LANGUAGE_VERSION = 1
"""The version of the scenario language that this release reads: ``cohaptic: 1``."""

MAX_FILES = 200
"""One scenario may pull in this many files; more is taken for a mistake."""


def read_document(name: str | PathLike[str], *, is_overlay: bool = False) -> tuple[Path, Node]:
    """A file with everything it includes, normalised, and the path where it was found.

    Raises:
        InputError: the file or a fragment cannot be used, or fragments include each other.
    """
    path = find_file(name)
    if path.is_relative_to(bundled_folder() / "presets"):
        raise InputError(
            f"{fspath(name)} is a preset for a part of a scenario; write 'include: {path.stem}' in "
            "the component or channel that is to have it."
        )
    return path, _Includes().read(path, (), (), needs_version=not is_overlay)


def expand(node: Node, at: tuple[PathKey, ...], folder: Path) -> Node:
    """A value with its includes, for the node at ``at``; relative names start from ``folder``.

    Raises:
        InputError: a fragment cannot be used.
    """
    return _Includes().expand(node, at, (folder / "--set",))


class _Includes:
    def __init__(self) -> None:
        self._files = 0

    def read(
        self, path: Path, at: tuple[PathKey, ...], stack: tuple[Path, ...], *, needs_version: bool
    ) -> Node:
        """A file with what it includes, for the node at ``at``."""
        self._files += 1
        if self._files > MAX_FILES:
            raise InputError(f"more than {MAX_FILES} files are included.")
        shown = shown_name(path)
        root = read_yaml(path, shown)
        if not isinstance(root.value, dict):
            raise InputError("a scenario file is a mapping, 'key: value' lines.", root.place)
        _check_version(root.value, root.place, needs_version)
        return self.expand(root, at, (*stack, _stacked(path)))

    def expand(self, node: Node, at: tuple[PathKey, ...], stack: tuple[Path, ...]) -> Node:
        """``node`` over what it includes; ``stack`` holds the files that led here."""
        if not isinstance(node.value, dict):
            return normalise(node, at)
        members = {
            key: self.expand(member, (*at, key), stack)
            for key, member in node.value.items()
            if key != "include"
        }
        own = normalise(Node(members, node.place, node.key_place), at)
        fragments = self._fragments(node.value.get("include"), at, stack)
        if not fragments:
            return own
        under = fragments[0]
        for fragment in fragments[1:]:
            under = merge(under, fragment, at)
        merged = merge(under, own, at)
        return Node(merged.value, node.place, node.key_place, merged.removed)

    def _fragments(
        self, include: Node | None, at: tuple[PathKey, ...], stack: tuple[Path, ...]
    ) -> list[Node]:
        if include is None:
            return []
        names = include.value if isinstance(include.value, list) else [include]
        return [self._fragment(name, at, stack) for name in names]

    def _fragment(self, name: Node, at: tuple[PathKey, ...], stack: tuple[Path, ...]) -> Node:
        if not isinstance(name.value, str):
            raise InputError("'include' takes a file name or a list of them.", name.place)
        path = find_file(name.value, beside=stack[-1].parent, location=name.place)
        if path.resolve() in stack:
            round_trip = " -> ".join(shown_name(file) for file in (*stack, path))
            raise InputError(f"files include each other: {round_trip}.", name.place)
        fragment = self.read(path, at, stack, needs_version=False)
        assert isinstance(fragment.value, dict)
        # What a fragment says about itself is not said about the scenario that includes it.
        inner = {
            key: node
            for key, node in fragment.value.items()
            if key not in {"cohaptic", "title", "description"}
        }
        return Node(inner, fragment.place, fragment.key_place, fragment.removed)


def _stacked(path: Path) -> Path:
    """The file as one that includes others; a pipe's includes start from the working folder."""
    shown = shown_name(path)
    is_file = path.is_file()
    return path.resolve() if is_file else folder_of(shown) / path.name


def _check_version(members: dict[str, Node], place: Location, needed: bool) -> None:
    version = members.get("cohaptic")
    if version is None:
        if needed:
            hint = did_you_mean("cohaptic", members, listed=0)
            raise InputError(
                f"the first line of a scenario is 'cohaptic: {LANGUAGE_VERSION}', the version of "
                f"its language; it is missing.{hint}",
                place,
            )
    elif version.value == str(LANGUAGE_VERSION):
        raise InputError(
            f"the version is a number: write 'cohaptic: {LANGUAGE_VERSION}', without quotes.",
            version.place,
        )
    elif version.value != LANGUAGE_VERSION or isinstance(version.value, bool):
        raise InputError(
            f"version {show(version.value)} of the scenario language; this cohaptic reads version "
            f"{LANGUAGE_VERSION}. Write 'cohaptic: {LANGUAGE_VERSION}' or install a newer one.",
            version.place,
        )
