"""How far a design point is from instability: in gain, in delay, in packet loss."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.chance.mean_square import critical_loss
from cosim.theory.models.mass_spring_damper import Centralized, Model
from cosim.theory.models.timing import Timing
from cosim.theory.stability.spectral_radius import stability, stable_intervals

FURTHEST_GAIN = 100.0
"""Gain margins are looked for between 1/100 and 100."""

NOT_LOOKED = "it was not looked further"
"""Why there is no answer beyond the furthest factor."""

FURTHEST_DELAY = 64
"""Delay margins are looked for up to so many network samples."""


@dataclass(frozen=True, slots=True)
class Margins:
    """Distances to instability, each with everything else as it is.

    Attributes:
        stiffness: the interval around 1 of factors on every virtual coupler's stiffness.
        damping: the interval around 1 of factors on every virtual coupler's damping.
        network: the interval around 1 of factors on what the network carries (K_12 and K_o, or
            K_2), None without a network.
        delay: how many more round-trip network samples stay stable; None without a network or
            where more than 64 do.
        loss: the critical loss probability (independent losses); None where there is none.
        open_ends: of intervals with an end that is no instability, by name: why there is no answer
            below and above it, or nothing.
    """

    stiffness: tuple[float, float]
    damping: tuple[float, float]
    network: tuple[float, float] | None
    delay: int | None
    loss: float | None
    open_ends: Mapping[str, tuple[str, str]] = field(
        default_factory=lambda: MappingProxyType[str, tuple[str, str]]({})
    )


def scaled(
    model: Model, stiffness: float = 1.0, damping: float = 1.0, *, network_only: bool = False
) -> Model:
    """The model with its virtual couplers' stiffness and damping multiplied.

    Args:
        model: any loop; walls, masses and compensation stay.
        stiffness: factor on stiffness.
        damping: factor on damping.
        network_only: leave the couplers alone that the network has no part in.
    """
    if isinstance(model, Centralized):
        k, b = model.stiffness * stiffness, model.damping * damping
        if network_only:
            k[0], b[0] = model.stiffness[0], model.damping[0]
        return replace(model, stiffness=k, damping=b)
    local = 0.0 if network_only else 1.0
    return replace(
        model,
        local_stiffness=model.local_stiffness * (stiffness if local else 1.0),
        local_damping=model.local_damping * (damping if local else 1.0),
        remote_stiffness=model.remote_stiffness * stiffness,
        remote_damping=model.remote_damping * damping,
        object_stiffness=model.object_stiffness * stiffness,
        object_damping=model.object_damping * damping,
    )


def margins(model: Model, timing: Timing) -> Margins:
    """All margins at a design point.

    Raises:
        InputError: where the design point itself is unstable.
    """
    found = stability(model, timing)
    if not found.stable:
        raise InputError(
            f"This loop is unstable (spectral radius {found.spectral_radius:.6g}), so it has no "
            "margins: lower the network couplers' stiffness or the delay first."
        )
    alone = isinstance(model, Centralized) and model.users == 1

    def around_one(make: Callable[[float], Model]) -> tuple[float, float]:
        return _around_one(lambda g: stability(make(g), timing).spectral_radius)

    network = None
    if not alone:
        network = around_one(lambda g: scaled(model, g, g, network_only=True))
    whole = timing.ratio.denominator == 1
    stiffness = around_one(lambda g: scaled(model, stiffness=g))
    damping = around_one(lambda g: scaled(model, damping=g))
    return Margins(
        stiffness=stiffness,
        damping=damping,
        network=network,
        delay=None if alone else _delay_margin(model, timing),
        loss=None if alone or not whole else critical_loss(model, timing),
        open_ends=open_ends(FURTHEST_GAIN, stiffness=stiffness, damping=damping, network=network),
    )


def open_ends(furthest: float, **found: tuple[float, float] | None) -> dict[str, tuple[str, str]]:
    """Of the intervals that reach as far as was looked, between 1/furthest and furthest, why."""
    ends: dict[str, tuple[str, str]] = {}
    for name, interval in found.items():
        low, high = interval or (1.0, 1.0)
        why = (
            NOT_LOOKED if low <= (1.0 + 1e-9) / furthest else "",
            NOT_LOOKED if high >= furthest * (1.0 - 1e-9) else "",
        )
        if any(why):
            ends[name] = why
    return ends


def _around_one(radius: Callable[[float], float]) -> tuple[float, float]:
    """The stable interval of factors that contains 1, on a logarithmic scale."""
    span = float(np.log(FURTHEST_GAIN))
    for low, high in stable_intervals(lambda x: radius(float(np.exp(x))), -span, span, points=80):
        if low <= 0.0 <= high:
            return float(np.exp(low)), float(np.exp(high))
    return 1.0, 1.0


def _delay_margin(model: Model, timing: Timing) -> int | None:
    start = timing.delay
    for extra in range(1, FURTHEST_DELAY + 1):
        late = replace(
            start,
            forward=start.forward + extra - extra // 2,
            backward=start.backward + extra // 2,
        )
        if not stability(model, replace(timing, delay=late)).stable:
            return extra - 1
    return None
