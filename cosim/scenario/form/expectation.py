"""What the scenario itself has to know of ``expect:``: which components a target speaks of."""

from __future__ import annotations


def components_in(target: str) -> list[str]:
    """Names of the components in a target; none for a measure of the whole scenario.

    ``a.x``, the difference ``a.x - b.x`` and the length ``|a.p - b.p|`` speak of components;
    ``contact_losses`` of the scenario.
    """
    sides = target.strip().strip("|").split(" - ")
    return [side.strip().partition(".")[0] for side in sides if "." in side]
