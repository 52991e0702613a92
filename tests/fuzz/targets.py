"""Every target by name."""

from __future__ import annotations

from collections.abc import Callable

from tests.fuzz import can_targets, canopen_targets, file_targets, link_targets, serial_targets
from tests.fuzz.seeds import SEEDS

__all__ = ["SEEDS", "TARGETS"]

TARGETS: dict[str, Callable[[bytes], None]] = {
    **serial_targets.TARGETS,
    **can_targets.TARGETS,
    **canopen_targets.TARGETS,
    **file_targets.TARGETS,
    **link_targets.TARGETS,
}
