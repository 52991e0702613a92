"""How a link behaves, from the ``link:`` settings of a channel."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from cosim.base.errors import InputError
from cosim.base.show import show
from cosim.base.suggest import did_you_mean
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
            InputError: an unknown name, or a value that makes no sense; ``where`` names the place.
        """
        unknown = [name for name in options if name not in _READERS]
        if unknown:
            hint = did_you_mean(unknown[0], _READERS, listed=len(_READERS))
            message = f"{where} has no link setting {unknown[0]}.{hint}"
            raise InputError(message)
        values: dict[str, Any] = {}
        for name, value in options.items():
            try:
                values[name] = _READERS[name](value)
            except (ValueError, TypeError) as error:
                message = f"{where}: {name} cannot be {show(value)}: {error}"
                raise InputError(message) from None
        policy = {name: values.pop(name) for name in list(values) if name in _POLICY}
        return cls(**values, loss=LossPolicy(**policy))


def _whole(minimum: int) -> Callable[[Any], int]:
    def read(value: Any) -> int:
        if isinstance(value, bool) or int(value) != value or value < minimum:
            message = f"it is a whole number, {minimum} or more"
            raise ValueError(message)
        return int(value)

    return read


def _seconds(value: Any) -> float:
    if isinstance(value, str):
        value = value.removesuffix("s").strip()
        scale = 1e-3 if value.endswith("m") else 1.0
        value = float(value.removesuffix("m")) * scale
    if isinstance(value, bool) or not 0.0 < float(value) <= 60.0:
        message = "it is a time above 0 and up to 60 s"
        raise ValueError(message)
    return float(value)


def _boolean(value: Any) -> bool:
    if not isinstance(value, bool):
        message = "it is true or false"
        raise TypeError(message)
    return value


def _auto(value: Any) -> int | None:
    return None if value == "auto" else _whole(1)(value)


_POLICY = ("hold_samples", "hold", "fade", "resume", "resume_samples", "ramp_at_start")
_READERS: Mapping[str, Callable[[Any], Any]] = {
    "release": Release,
    "delay": _auto,
    "max_delay": _whole(1),
    "clock": ClockMode,
    "add_impairments": _boolean,
    "hold_samples": _whole(1),
    "hold": _seconds,
    "fade": _seconds,
    "resume": _seconds,
    "resume_samples": _whole(1),
    "ramp_at_start": _boolean,
}
