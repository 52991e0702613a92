"""How a link behaves, from the ``link:`` settings of a channel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import StrEnum
from typing import Any

from cosim.base.document.form import plain_node, read_form
from cosim.base.errors import Location
from cosim.link.stream.form import LinkForm
from cosim.link.stream.peer import LossPolicy
from cosim.link.stream.receiver import Release

LONGEST_DELAY = 16
"""Samples, where neither the scenario nor its theory says how long the way may be."""


class ClockMode(StrEnum):
    """What keeps the grids of two stations together."""

    FOLLOW = "follow"
    """The station whose name sorts first leads; the others slew their tick period."""
    FREE = "free"
    """Every station keeps its own period; the slip is recorded."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkSettings:
    """Settings of a real link; what is not given has the documented default."""

    release: Release = Release.NETWORK_TICK
    delay: int | None = 1
    """Least delay in samples; a packet that arrives sooner is held, so that n stays whole. ``None``
    (``auto``): what nine packets of ten need, measured before the start and then kept."""
    max_delay: int | None = None
    """Longest way in samples that may count; ``None``: as the theory of the scenario says."""
    clock: ClockMode = ClockMode.FOLLOW
    add_impairments: bool = False
    """Whether the channel's simulated delay, jitter and loss come on top of the real link's."""
    loss: LossPolicy = field(default_factory=LossPolicy)

    @property
    def longest_delay(self) -> int:
        """The longest way in samples after which a packet's values may still be used."""
        return max(self.max_delay or LONGEST_DELAY, self.delay or 1)

    @classmethod
    def read(cls, options: Mapping[str, Any], where: str) -> LinkSettings:
        """The settings in a mapping.

        Raises:
            InputError: unknown names, or values that make no sense; ``where`` names the place.
        """
        node = plain_node(options, Location(where, 0, 0))
        given = read_form(LinkForm, node, "'link'").model_dump(exclude_none=True)
        policy = {name: given.pop(name) for name in list(given) if name in _POLICY}
        if "release" in given:
            given["release"] = Release(given["release"])
        if given.get("delay") == "auto":
            given["delay"] = None
        if "clock" in given:
            given["clock"] = ClockMode(given["clock"])
        return cls(**given, loss=LossPolicy(**policy))


_POLICY = frozenset(field.name for field in fields(LossPolicy))
