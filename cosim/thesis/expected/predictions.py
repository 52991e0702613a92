"""Where the limits of each piece of evidence come from: computed here, before any run.

Nothing here uses the kernel: closed forms, statics, the theory, computations in plain Python. What
is chosen is how far a measured value may be from a predicted one; ``tolerance`` says it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Literal

from cosim.thesis.expected.impact import impact
from cosim.thesis.expected.single_axis import (
    LINEAR,
    ON_THE_TABLE,
    TURNING,
    TwoCopies,
    net_force_amplitude,
)
from cosim.thesis.expected.statics import (
    SHORT_WAY,
    carried,
    lag,
    outer_force,
    pressed_apart,
    pulled_apart,
)
from cosim.thesis.expected.statics import WAY as LONG_WAY

WALL = 2 * 4000.0
"""Stiffness of the wall under two corners (N/m)."""

PUSH = 1.5
"""Of the emulated user (N)."""

TOLERANCE = 0.1
"""Chosen: a measured value may be off by this share of the predicted one."""

Origin = Literal["predicted", "stated"]


@dataclass(frozen=True, slots=True)
class Expected:
    """One expectation's limit: of which target, by which predicate, and where it lies (SI).

    ``tolerance`` is how far the limits of a ``…_within`` lie from the value, as a share of it; a
    bound has none. ``zero`` is where the target has the value 0.
    """

    target: str
    predicate: str
    value: Callable[[], float]
    tolerance: float = 0.0
    zero: float = 0.0

    def bounds(self) -> tuple[float, ...]:
        """The limit, or both of them in order."""
        value = self.value()
        if not self.predicate.endswith("within"):
            return (self.zero + value,)
        off = abs(value) * self.tolerance
        first, last = self.zero + value - off, self.zero + value + off
        return (first, last)


class Prediction:
    """Why the limits of a label lie where they do.

    ``origin`` is ``predicted`` where they are computed, ``stated`` where a number of the statement
    itself is the limit.
    """

    def __init__(self, derivation: str, *limits: Expected, origin: Origin = "predicted") -> None:
        self.derivation, self.limits, self.origin = derivation, limits, origin

    @property
    def sentence(self) -> str:
        """Predicted or stated, from what, and the tolerance that is chosen."""
        chosen = {each.tolerance for each in self.limits if each.tolerance}
        off = "".join(f"; {share:.0%} either way is chosen" for share in sorted(chosen))
        return f"{self.origin}: {self.derivation}{off}"


_NET = "vr_a.finger_1.normal_force - vr_b.finger_1.normal_force"
_NET_CENTRAL = "server.finger_1.normal_force - server.client_contact_1.finger_1_normal_force"


def _force(target: str, compensation: float, axis: TwoCopies, tolerance: float = 0.1) -> Prediction:
    return Prediction(
        "independent computation on a single axis",
        Expected(
            target,
            "amplitude_within",
            lambda: net_force_amplitude(1, compensation, axis),
            tolerance,
        ),
    )


def _nulled(axis: TwoCopies) -> Prediction:
    return Prediction(
        "independent computation on a single axis, with the theory's null",
        Expected(
            _NET, "amplitude_within", lambda: net_force_amplitude(1, null(axis), axis), TOLERANCE
        ),
    )


def _turned(compensation: float, tolerance: float = 0.1) -> Prediction:
    found = _force("vr_a.finger_wrench.theta", compensation, TURNING, tolerance)
    return Prediction(
        f"{found.derivation}; stable in theory, so no contact ends", *found.limits, _KEPT[0]
    )


@cache
def null(axis: TwoCopies) -> float:
    """What nulls the added damping at n = 1 in the full model, on both copies (N·s/m)."""
    from cosim.theory.models.parameters import TABLE_6_1, Parameters
    from cosim.theory.models.timing import PathDelay, Timing
    from cosim.theory.transparency.compensation import null_compensation

    gains = {"11": axis.local, "12": axis.remote, "o": axis.between}
    values = {f"{kind}_{name}": of[i] for name, of in gains.items() for i, kind in enumerate("kb")}
    model = Parameters("distributed", values, TABLE_6_1["distributed"]).model()
    return null_compensation(model, Timing(delay=PathDelay.round_trip(1)), 0).value


def _alternating() -> float:
    """Growth (1/s) of the centralized loop of table 6.1, a sample up and down in turns."""
    from cosim.theory.models.parameters import TABLE_6_1, Parameters
    from cosim.theory.models.timing import Timing
    from cosim.theory.robust.joint_radius import joint_radius
    from cosim.theory.robust.network import switching_delays

    model, timing = Parameters("centralized", {}, TABLE_6_1["centralized"]).model(), Timing()
    worst = joint_radius(switching_delays(model, timing, (0, 1), (0, 1))[0])
    return math.log(worst.lower) / float(timing.ratio * timing.control_period)


def _yield(finger: str, stiffness: float) -> Prediction:
    return Prediction(
        f"{PUSH:g} N over {stiffness:g} N/m and the wall's {WALL:g} N/m in series",
        Expected(
            f"{finger}.tip_position[2]",
            "peak_to_peak_within",
            lambda: PUSH * (1.0 / stiffness + 1.0 / WALL),
            TOLERANCE,
        ),
    )


def _at(target: str, predicate: str, value: float, tolerance: float = 0.0) -> Expected:
    return Expected(target, predicate, lambda: value, tolerance)


_STEADY = Expected("force_ripple", "below", outer_force)
_KEPT = (_at("contact_losses", "equals", 0.0), _at("held_fraction", "equals", 1.0))
_OUTER = (
    "what acts from outside, 0.289 N: 0.196 N of ground, 0.042 N of joints, 0.025 N of inertia, "
    "0.025 N of an encoder count"
)
_QUIET = f"stable in theory, so no contact ends and no force varies by more than {_OUTER}"


def _held(samples: int) -> Prediction:
    return Prediction(
        f"{_QUIET}; the way less friction's share; K_o and K_12 against 0.196 N of ground"
        + (f", and {samples} sample more one way than the other" if samples else ""),
        *_KEPT,
        _STEADY,
        Expected("box_displacement", "above", lambda: carried(2, 4, LONG_WAY)),
        Expected("drift", "below", lambda: lag(samples)),
    )


def _many(users: int) -> Prediction:
    return Prediction(
        f"{_QUIET}; the way less friction's share; statics of two pushes of 2 N, hands, K_11, "
        "K_12, K_o and friction",
        *_KEPT,
        _STEADY,
        Expected("box_displacement", "above", lambda: carried(users, users, SHORT_WAY)),
        Expected("drift", "below", lambda: pressed_apart(users)),
    )


def _impact(*, impulses: bool) -> Prediction:
    return Prediction(
        "independent computation of hand, box and wall on one axis",
        Expected(
            "finger_a.tip_position[2]",
            "max_within",
            lambda: impact(impulses=impulses).deepest,
            TOLERANCE,
            zero=-0.05,
        ),
        Expected(
            "vr_a.finger_1.contact_state",
            "change_count_equals",
            lambda: float(impact(impulses=impulses).changes),
        ),
    )


PREDICTIONS: Mapping[tuple[str, str], Prediction] = {
    ("grasp_centralized", "instability"): Prediction(
        f"unstable in theory, so that a force varies by more than {_OUTER}",
        Expected("force_ripple", "above", outer_force),
    ),
    ("grasp_distributed", "grasp"): _held(1),
    ("grasp_distributed_n0", "grasp"): _held(0),
    ("grasp_distributed_n2", "grasp"): _held(0),
    ("grasp_distributed_lan_2006", "grasp"): _held(0),
    ("grasp_distributed_lossy", "grasp"): _held(1),
    ("grasp_distributed_apart", "together"): Prediction(
        "stable in theory, so no contact ends; statics of hands, K_11, K_o, fingers that slide and "
        "friction",
        _KEPT[0],
        Expected("drift", "below", lambda: pulled_apart(0.015)),
    ),
    ("grasp_centralized_firm_hand", "damped_hand"): Prediction(_QUIET, _KEPT[0], _STEADY),
    ("grasp_centralized_soft", "softer"): Prediction(_QUIET, *_KEPT, _STEADY),
    ("wall_push_centralized_remote", "soft_contact"): _yield("finger_b", 170.0),
    ("wall_push_centralized_stiffest", "stiffest"): _yield("finger_b", 200.0),
    ("wall_push_centralized_local", "stiff_contact"): _yield("finger_a", 800.0),
    ("wall_push_distributed", "stiff_contact"): _yield("finger_a", 800.0),
    ("free_motion_local", "local"): Prediction(
        "0.4 kg times 0.05 m times (2 rad/s)²",
        _at(_NET_CENTRAL, "amplitude_within", 0.4 * 0.05 * 4.0, TOLERANCE),
    ),
    ("free_motion", "uncompensated"): _force(_NET, 0.0, LINEAR),
    ("free_motion_compensated", "compensated"): _nulled(LINEAR),
    ("free_motion_printed", "printed"): _force(_NET, -0.88, LINEAR),
    ("free_motion_ground", "ground"): _force(_NET, 0.0, ON_THE_TABLE),
    ("free_motion_ground_printed", "ground"): _force(_NET, -0.88, ON_THE_TABLE),
    ("free_motion_ground_compensated", "ground"): _nulled(ON_THE_TABLE),
    ("turning", "turning"): _turned(0.0),
    ("turning_printed", "turning"): _turned(-0.025, tolerance=0.2),
    ("rigid_contact", "no_impulses"): _impact(impulses=False),
    ("rigid_contact_cancelled", "impulses"): _impact(impulses=True),
    ("sliding", "breaks_away"): Prediction(
        "static friction, 0.6 times 1 N",
        _at("vr_a.finger_1.tangential_force", "max_abs_within", 0.6, TOLERANCE),
    ),
    ("sliding", "slides"): Prediction(
        "kinetic friction, 0.3 times 1 N",
        _at("vr_a.finger_1.tangential_force", "mean_within", -0.3, TOLERANCE),
    ),
    ("three_users", "three_users"): _many(3),
    ("four_users", "four_users"): _many(4),
    ("grasp_deformable", "deformable"): Prediction(
        f"{_QUIET}; the way less friction's share",
        _KEPT[0],
        _STEADY,
        Expected("box_displacement", "above", lambda: carried(2, 4, LONG_WAY)),
    ),
    ("grasp_centralized_passive", "passive"): Prediction(
        f"a controller that takes what the loop makes leaves {_OUTER}", _STEADY
    ),
    ("grasp_centralized_wave", "wave"): Prediction(
        f"wave variables are passive at any delay; {_QUIET}", _KEPT[0], _STEADY
    ),
    ("alternating_delays", "alternating"): Prediction(
        "joint spectral radius of both delays' maps, 1.000628 a period",
        Expected("hand_2.position - object.position", "growth_within", _alternating, 0.03),
    ),
    ("grasp_deadband", "deadband"): Prediction(
        f"four packets in five of 128 a second in 10 s; {_QUIET}; the way less friction's share",
        *_KEPT,
        _STEADY,
        Expected("box_displacement", "above", lambda: carried(2, 4, LONG_WAY)),
        _at("vr_a.packets_due", "final_equals", 1280.0),
        _at("vr_a.packets_sent", "final_below", 256.0),
        origin="stated",
    ),
}
"""Scenario and label -> where the limits come from."""
