"""The free motion of figure 8.3 under changes: what realism costs, what prediction gains."""

from __future__ import annotations

from collections.abc import Mapping

ENCODERS = (
    "components.finger_{u}.parameters.encoder_counts=0",
    "components.vr_{u}.parameters.finger_1.encoder_counts=0",
)
DAC = ("components.finger_{u}.parameters.dac_bits=0",)
AMPLIFIER = ("components.finger_{u}.parameters.amplifier_bandwidth=0",)
FRICTION = (
    "components.finger_{u}.parameters.coulomb_friction=0",
    "components.finger_{u}.parameters.viscous_friction=0",
)


def _difference(window: int) -> tuple[str, ...]:
    return (
        "components.vr_{u}.parameters.velocity_estimator=finite_difference",
        f"components.vr_{{u}}.parameters.velocity_window={window}",
    )


def _both(*sets: str) -> tuple[str, ...]:
    return tuple(one.format(u=user) for one in sets for user in "ab")


DURATION = ("duration=10.86",)
"""Two periods after the motion has swung in."""

REALISM: Mapping[str, tuple[str, ...]] = {
    "as built": DURATION,
    "ideal encoders": DURATION + _both(*ENCODERS),
    "ideal DAC": DURATION + _both(*DAC),
    "ideal amplifiers": DURATION + _both(*AMPLIFIER),
    "velocity: difference over 1 tick": DURATION + _both(*_difference(1)),
    "velocity: difference over 16 ticks": DURATION + _both(*_difference(16)),
    "no friction in the joints": DURATION + _both(*FRICTION),
    "all ideal": DURATION + _both(*ENCODERS, *DAC, *AMPLIFIER, *FRICTION, *_difference(1)),
}
"""What is made ideal -> overrides; an exact angle's difference over a tick is an ideal velocity."""

DELAYS = (2, 3, 4)
"""Round trips at which the predictors are compared, in network samples."""

PREDICTORS = ("hold_last", "linear")


def prediction(predictor: str, delay: int) -> tuple[str, ...]:
    """Overrides for the free motion with a predictor at a round trip of ``delay`` samples."""
    return (
        *DURATION,
        f"channels.lan.round_trip_delay={delay}",
        *_both(f"components.vr_{{u}}.parameters.predictor={predictor}"),
    )
