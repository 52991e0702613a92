"""From a scenario file, overlays and ``--set`` overrides to a checked :class:`Scenario`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from cosim.base.document.node import Node
from cosim.base.system.garbage import without_collecting
from cosim.scenario.model import Scenario

if TYPE_CHECKING:
    from cosim.scenario.form.sections import Forms


@dataclass(frozen=True, slots=True)
class Written:
    """A scenario as it is written, read and merged, before it is judged."""

    file: Path
    root: Node
    forms: Forms | None = None
    """Those of the sections that others obey (``cosim.scenario.form.sections``)."""

    def changed(self, sets: Sequence[str]) -> Written:
        """The same with further overrides."""
        from cosim.scenario.source.override import apply_override

        root = self.root
        for override in sets:
            root = apply_override(root, override)
        return Written(self.file, root, self.forms)

    def with_value(self, keys: Sequence[str], written: str, given: str) -> Written:
        """The same with a value (YAML) at ``keys``, as the override ``given`` said it."""
        from cosim.scenario.source.override import put

        return Written(self.file, put(self.root, keys, written, given), self.forms)

    def built(self) -> Scenario:
        """The checked scenario.

        Raises:
            InputError: one or more (``InputErrors``) problems, each with its place.
        """
        from cosim.scenario.build.scenario import build

        with without_collecting():
            return build(self.root, self.file, self.forms)


def read(
    path: str | PathLike[str],
    overlays: Sequence[str | PathLike[str]] = (),
    sets: Sequence[str] = (),
    *,
    forms: Forms | None = None,
) -> Written:
    """Read a scenario's files, each once: a pipe cannot be read again.

    ``path`` and ``overlays`` are found as files first and then by bundled name, with or without
    ``scenarios/`` and ``.yaml``; ``-`` is standard input. ``sets`` are ``a.b=c`` overrides,
    applied after the overlays. ``forms`` are those of the sections that others obey.

    Raises:
        InputError: a file cannot be read, or an override leads nowhere.
    """
    from cosim.scenario.source.include import read_document
    from cosim.scenario.source.merge import merge

    with without_collecting():
        file, root = read_document(path)
        for overlay in overlays:
            root = merge(root, read_document(overlay, is_overlay=True)[1])
        return Written(file, root, forms).changed(sets)


def load(
    path: str | PathLike[str],
    overlays: Sequence[str | PathLike[str]] = (),
    sets: Sequence[str] = (),
    *,
    forms: Forms | None = None,
) -> Scenario:
    """Read and check a scenario; the arguments are those of ``read``.

    What has to be computed (``compensation: auto``) stays as it is written; see
    ``cosim.analysis.load_tuned``.

    Raises:
        InputError: one or more (``InputErrors``) problems, each with its place.
    """
    return read(path, overlays, sets, forms=forms).built()
