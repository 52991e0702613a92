"""Gains that follow from the network: the stiffest couplers that stand every promised corner.

Every stiffness grows by the same small factors for as long as any can, dampings moving along where
that lets one grow, in the few corners that have mattered so far; then all corners are checked, the
gains are taken back until they hold, and at last the compensation is, which has to stand them too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from cosim.base.errors import InputError
from cosim.theory.chance.network import Network
from cosim.theory.design.corners import corners_of
from cosim.theory.design.judge import CornerJudge
from cosim.theory.design.limits import reliefs, worst_cause
from cosim.theory.models.parameters import Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.transparency.compensation import null_compensation

STIFFNESS = {"centralized": ("k_1", "k_2"), "distributed": ("k_11", "k_12", "k_o")}
DAMPING = {"centralized": ("b_1", "b_2"), "distributed": ("b_11", "b_12", "b_o")}
_START = {"k_1": 500.0, "k_2": 50.0, "k_11": 500.0, "k_12": 100.0, "k_o": 100.0} | {
    "b_1": 10.0,
    "b_2": 3.0,
    "b_11": 10.0,
    "b_12": 3.0,
    "b_o": 5.0,
}
_TAKEN_BACK = 0.93
_FACTORS = (2.0, 1.3, 1.08)


@dataclass(frozen=True, slots=True)
class Design:
    """Gains, what they stand, and what keeps them from being stiffer.

    Attributes:
        gains: every designed or given stiffness and damping, by the thesis's names.
        compensation: b_c per object copy, N·s/m.
        corners: the radius in every promised corner, compensation included; below 1.
        worst: the corner that is nearest to 1.
        limits: per free stiffness and cause, by what factor it could grow on its own if the cause
            were gone (the network rate raised to the control rate, the control rate doubled);
            empty unless asked for.
        timing: rates and the fixed part of the delay.
    """

    gains: dict[str, float]
    compensation: float
    corners: dict[str, float]
    worst: str
    limits: dict[str, dict[str, float]]
    timing: Timing

    @property
    def limited_by(self) -> dict[str, str]:
        """Per free stiffness, the cause that costs most; ``itself`` where none matters."""
        return {name: worst_cause(causes) for name, causes in self.limits.items()}


def design(
    parameters: Parameters,
    network: Network,
    control_period: Fraction,
    margin: float,
    *,
    explain: bool = False,
    computation_delay: int = 0,
) -> Design:
    """Find the stiffest couplers for a network.

    Args:
        parameters: masses and whatever else is given; a gain that is given is kept.
        network: both directions' rate, delay, jitter and loss.
        control_period: T_c in s.
        margin: m, see ``corners_of``.
        explain: find out what limits each stiffness, which takes longer.
        computation_delay: ticks of T_c between a coupler's inputs and its force.

    Raises:
        InputError: where no gains stand the corners, or the given ones do not.
    """
    if not (math.isfinite(margin) and margin >= 0):
        raise InputError(f"The margin is {margin:g}: give a number such as 0.25 for 25 %.")
    ratio = network.period / control_period
    if ratio.denominator != 1:
        nearest = max(1, round(ratio))
        raise InputError(
            f"The control rate must be a multiple of the network rate for the design; the ratio is "
            f"{float(ratio):.4g}. The nearest network rate that fits is "
            f"{float(1 / (control_period * nearest)):.6g} Hz."
        )
    delay = PathDelay.each_way(network.fixed_delay)
    timing = Timing(control_period, ratio, delay, computation_delay)
    names = STIFFNESS[parameters.architecture] + DAMPING[parameters.architecture]
    start = {name: _START[name] for name in names if not _is_given(parameters, name)}
    judge = CornerJudge(parameters, network, timing, corners_of(parameters, network, margin))
    gains = _search(judge.quick, start)
    if gains is None:
        raise InputError(_no_design(parameters, network, margin))
    gains = _confirmed(judge, gains, _no_design(parameters, network, margin))
    compensation = _compensation(judge, gains)
    resolved = parameters.replaced(gains)
    radii = judge.radii(gains, compensation)
    limits: dict[str, dict[str, float]] = {}
    if explain:
        limits = {n: reliefs(judge, gains, n, margin) for n in gains if n[0] == "k"}
    return Design(
        gains={name: resolved[_leaf(resolved, name)] for name in names},
        compensation=compensation,
        corners=radii,
        worst=max(radii, key=lambda name: radii[name]),
        limits=limits,
        timing=timing,
    )


def _search(
    stable: Callable[[Mapping[str, float]], bool], start: dict[str, float]
) -> dict[str, float] | None:
    """Grow stiffness in logarithms, and move a damping where that lets one grow."""
    gains = dict(start)
    for _ in range(16):
        if stable(gains):
            break
        gains = {name: value / (2.0 if name[0] == "k" else 1.3) for name, value in gains.items()}
    else:
        return None
    stiff = [name for name in gains if name[0] == "k"]
    damped = [name for name in gains if name[0] == "b"]
    for factor in _FACTORS:
        growing = list(stiff)
        while growing:
            growing = [name for name in growing if _grown(stable, gains, {name: factor})]
        for other in damped:
            for turn in (1.25, 0.8):
                for name in stiff[-2:]:
                    _grown(stable, gains, {other: turn, name: factor})
    return gains


def _grown(
    stable: Callable[[Mapping[str, float]], bool],
    gains: dict[str, float],
    factors: Mapping[str, float],
) -> bool:
    """Multiply some gains in place, if that is stable."""
    trial = {**gains, **{name: gains[name] * factor for name, factor in factors.items()}}
    if any(value > 1e5 for value in trial.values()) or not stable(trial):
        return False
    gains.update(trial)
    return True


def _confirmed(judge: CornerJudge, gains: dict[str, float], refusal: str) -> dict[str, float]:
    """Take the stiffness back until every corner holds."""
    for _ in range(90):
        if judge.steady(gains) and judge.lossy(gains):
            return gains
        gains = {
            name: value * (_TAKEN_BACK if name[0] == "k" else 1.0) for name, value in gains.items()
        }
    raise InputError(refusal)


def _compensation(judge: CornerJudge, gains: Mapping[str, float]) -> float:
    """The null at the shortest delay, taken back until every corner holds with it."""
    parameters, network = judge.parameters.replaced(gains), judge.network
    shortest = network.fixed_delay
    if network.jitter > 0:
        shortest = next(i for i, p in enumerate(network.delay_probabilities()) if p > 1e-3)
    user = 1 if parameters.architecture == "centralized" else 0
    alone = parameters.model(tuple(m == user for m in range(parameters.users)))
    quickest = replace(judge.timing, delay=PathDelay.each_way(shortest))
    value = null_compensation(alone, quickest, user).value
    share = 1.0
    if not judge.steady(gains, value):
        low, high = 0.0, 1.0
        for _ in range(6):
            middle = (low + high) / 2
            low, high = (middle, high) if judge.steady(gains, middle * value) else (low, middle)
        share = low
    while share > 1e-3 and not judge.lossy(gains, share * value):
        share *= 0.8
    return share * value if share > 1e-3 else 0.0


def _is_given(parameters: Parameters, name: str) -> bool:
    return parameters.source(_leaf(parameters, name)) in parameters.given


def _leaf(parameters: Parameters, name: str) -> str:
    return name if name in parameters.leaves else f"{name}1"


def _no_design(parameters: Parameters, network: Network, margin: float) -> str:
    kept = sorted(name for name in parameters.given if name[0] in "kb")
    what = f"Take back {', '.join(kept)}" if kept else "Lower the loss or the delay"
    return (
        f"No {parameters.architecture} gains stand all corners with a margin of {margin:g} "
        f"over this network (delay {network.delay:g} s, jitter {network.jitter:g} s, loss "
        f"{network.loss:g}). {what}, ask for a smaller margin, or use another architecture."
    )
