"""Reading a scenario with everything that judges it."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike

from cosim.analysis import load_tuned
from cosim.cli.support.forms import FORMS
from cosim.scenario import Scenario


def load(
    path: str | PathLike[str],
    overlays: Sequence[str | PathLike[str]] = (),
    sets: Sequence[str] = (),
) -> Scenario:
    """A scenario as ``cohaptic run`` reads it: every section judged, ``compensation: auto`` solved.

    Raises:
        InputError: one or more (``InputErrors``) problems, each with its place.
    """
    return load_tuned(path, overlays, sets, forms=FORMS)
