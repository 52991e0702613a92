"""From a scenario file, overlays and ``--set`` overrides to a checked :class:`Scenario`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike

from cosim.base.garbage import without_collecting
from cosim.scenario.model import Scenario


def load(
    path: str | PathLike[str],
    overlays: Sequence[str | PathLike[str]] = (),
    sets: Sequence[str] = (),
) -> Scenario:
    """Read a scenario.

    ``path`` and ``overlays`` are found as files first and then by bundled name, with or without
    ``scenarios/`` and ``.yaml``. ``sets`` are ``a.b=c`` overrides, applied after the overlays.

    Raises:
        InputError: one or more (``InputErrors``) problems, each with its place.
    """
    from cosim.scenario.build.scenario import build
    from cosim.scenario.source.include import read_document
    from cosim.scenario.source.merge import merge
    from cosim.scenario.source.override import apply_override

    with without_collecting():
        file, root = read_document(path)
        for overlay in overlays:
            root = merge(root, read_document(overlay, is_overlay=True)[1])
        for override in sets:
            root = apply_override(root, override)
        return build(root, file)
