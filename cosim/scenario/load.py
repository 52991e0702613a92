"""From a scenario file, overlays and ``--set`` overrides to a checked :class:`Scenario`."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike

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
    raise NotImplementedError
