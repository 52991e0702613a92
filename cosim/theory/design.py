"""Gains that follow from the network: the stiffest couplers that stay mean-square stable.

Searched are the stiffness and the damping of every coupler, and, at the end, the compensation:
every stiffness grows by the same small factors for as long as any can, dampings moving along where
that lets one grow, so that none is bought with another. *Margin* m means: still mean-square stable
with every stiffness, every damping, or both, multiplied by 1 + m.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from cosim.base.errors import InputError
from cosim.theory.chance.mean_square import mean_square_radius
from cosim.theory.chance.network import Network
from cosim.theory.chance.packets import LinkProcess, independent_frames
from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.parameters import Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.margins import scaled
from cosim.theory.stability.spectral_radius import stability
from cosim.theory.transparency.compensation import null_compensation
from cosim.theory.transparency.damping import uniform_compensation

STIFFNESS = {"centralized": ("k_1", "k_2"), "distributed": ("k_11", "k_12", "k_o")}
DAMPING = {"centralized": ("b_1", "b_2"), "distributed": ("b_11", "b_12", "b_o")}
_START = {"k_1": 500.0, "k_2": 50.0, "k_11": 500.0, "k_12": 100.0, "k_o": 100.0} | {
    "b_1": 10.0,
    "b_2": 3.0,
    "b_11": 10.0,
    "b_12": 3.0,
    "b_o": 5.0,
}
CAUSES = ("loss", "jitter", "delay", "network rate", "control rate")
"""What can be in the way of more stiffness."""


@dataclass(frozen=True, slots=True)
class Design:
    """Gains, and what keeps them from being stiffer.

    Attributes:
        gains: every designed or given stiffness and damping, by the thesis's names.
        compensation: b_c per object copy, N·s/m.
        mean_square_radius: of the loop with these gains and that b_c, per frame.
        limits: per free stiffness and cause, by what factor it could grow on its own if the cause
            were gone (the network rate raised to the control rate, the control rate doubled).
        limited_by: per free stiffness, the cause that costs most; ``itself`` where none matters.
        timing: rates and the fixed part of the delay.
    """

    gains: dict[str, float]
    compensation: float
    mean_square_radius: float
    limits: dict[str, dict[str, float]]
    limited_by: dict[str, str]
    timing: Timing


def design(
    parameters: Parameters, network: Network, control_period: Fraction, margin: float
) -> Design:
    """Find the stiffest couplers for a network.

    Args:
        parameters: masses and whatever else is given; a gain that is given is kept.
        network: both directions' rate, delay, jitter and loss.
        control_period: T_c in s.
        margin: m > 0, see above.

    Raises:
        InputError: where no gains are stable with that margin, or the given ones are not.
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
    samples = network.fixed_delay
    timing = Timing(control_period, ratio, PathDelay.each_way(samples))
    names = STIFFNESS[parameters.architecture] + DAMPING[parameters.architecture]
    free = [name for name in names if not _is_given(parameters, name)]
    start = {name: _START[name] for name in free}

    def stable(gains: Mapping[str, float], on: Network, clock: Timing) -> bool:
        model = parameters.replaced(gains).model()
        return _stable_with_margin(model, clock, independent_frames(on.process()), margin)

    # Searched with the mean delay and the loss; the jitter, and its memory, then take back.
    steady = replace(network, jitter=0.0)
    gains = _search(lambda g: stable(g, steady, timing), start)
    if gains is None:
        raise InputError(_no_design(parameters, network, margin))
    gains = _confirm(parameters, gains, timing, network, margin)
    resolved = parameters.replaced(gains)
    limits = {
        name: _reliefs(stable, (steady, network), timing, gains, name)
        for name in gains
        if name[0] == "k"
    }
    compensation = _compensation(resolved, network, timing)
    final = uniform_compensation(resolved.model(), compensation)
    process = network.process()
    return Design(
        gains={name: resolved[_leaf(resolved, name)] for name in names},
        compensation=compensation,
        mean_square_radius=mean_square_radius(final, timing, lambda _: process),
        limits=limits,
        limited_by={name: _worst(causes) for name, causes in limits.items()},
        timing=timing,
    )


def _worst(causes: Mapping[str, float]) -> str:
    worst = max(causes, key=lambda cause: causes[cause])
    return worst if causes[worst] > 1.1 else "itself"


def _reliefs(
    stable: Callable[[Mapping[str, float], Network, Timing], bool],
    networks: tuple[Network, Network],
    timing: Timing,
    gains: dict[str, float],
    name: str,
) -> dict[str, float]:
    """By what factor one stiffness could be larger with one cause gone, for every cause.

    The others are taken back by a tenth, so that what is measured is not their own limits. All but
    the jitter are judged with the mean delay.
    """
    steady, jittery = networks
    eased = {n: v * (0.9 if n[0] == "k" and n != name else 1.0) for n, v in gains.items()}
    as_it_is = _growth(lambda g: stable(g, steady, timing), eased, name)
    reliefs: dict[str, float] = {}
    for cause in CAUSES:
        better, clock = steady.without(cause), timing
        if cause in {"delay", "network rate"}:
            clock = replace(clock, delay=PathDelay())
        if cause == "network rate":
            better = Network(timing.control_period, 0.0, 0.0, steady.loss)
            clock = replace(clock, ratio=Fraction(1))
        if cause == "control rate":
            clock = replace(clock, control_period=clock.control_period / 2, ratio=clock.ratio * 2)
        if cause == "jitter":
            now = as_it_is
            if len(jittery.process().events) > 2:
                now = _growth(lambda g: stable(g, jittery, timing), eased, name)
            reliefs[cause] = as_it_is / now
        elif (better, clock) == (steady, timing):
            reliefs[cause] = 1.0
        else:
            free = _growth(lambda g, on=better, at=clock: stable(g, on, at), eased, name)
            reliefs[cause] = free / as_it_is
    return reliefs


def _confirm(
    parameters: Parameters,
    gains: dict[str, float],
    timing: Timing,
    network: Network,
    margin: float,
) -> dict[str, float]:
    """Take the stiffness back until the exact packet process, with its memory, agrees."""
    exact = network.process()
    if exact.transition.shape[0] == 1 and network.jitter == 0.0:
        return gains
    for process in (independent_frames(exact), exact):
        for _ in range(60):
            model = parameters.replaced(gains).model()
            if _stable_with_margin(model, timing, process, margin):
                break
            gains = {name: value * (0.93 if name[0] == "k" else 1) for name, value in gains.items()}
        else:
            raise InputError(_no_design(parameters, network, margin))
    return gains


def _is_given(parameters: Parameters, name: str) -> bool:
    return parameters.source(_leaf(parameters, name)) in parameters.given


def _leaf(parameters: Parameters, name: str) -> str:
    return name if name in parameters.leaves else f"{name}1"


def _stable_with_margin(model: Model, timing: Timing, process: LinkProcess, margin: float) -> bool:
    corners = {(1.0, 1.0), (1 + margin, 1.0), (1.0, 1 + margin), (1 + margin, 1 + margin)}
    for k, b in sorted(corners, reverse=True):
        corner = scaled(model, k, b)
        # The mean delay without loss refuses most points at a tenth of the price.
        if not stability(corner, timing).stable:
            return False
        if mean_square_radius(corner, timing, lambda _: process) >= 1.0 - 1e-12:
            return False
    return True


def _search(
    stable: Callable[[Mapping[str, float]], bool], start: dict[str, float]
) -> dict[str, float] | None:
    """Compass search in logarithms: grow stiffness, move damping where that lets it grow."""
    gains = dict(start)
    for _ in range(16):
        if stable(gains):
            break
        gains = {name: value / (2.0 if name[0] == "k" else 1.3) for name, value in gains.items()}
    else:
        return None
    stiff = [name for name in gains if name[0] == "k"]
    damped = [name for name in gains if name[0] == "b"]
    for factor in (2.0, 1.4, 1.12, 1.04):
        for _ in range(40):
            moved = _grow(stable, gains, stiff, factor)
            if moved is None:
                moved = _trade(stable, gains, stiff, damped, factor)
            if moved is None:
                break
            gains = moved
    return gains


def _grow(
    stable: Callable[[Mapping[str, float]], bool],
    gains: dict[str, float],
    stiff: Sequence[str],
    factor: float,
) -> dict[str, float] | None:
    """Every stiffness that can grow by the factor, grown."""
    better: dict[str, float] | None = None
    for name in stiff:
        trial = {**(better or gains), name: (better or gains)[name] * factor}
        if stable(trial):
            better = trial
    return better


def _trade(
    stable: Callable[[Mapping[str, float]], bool],
    gains: dict[str, float],
    stiff: Sequence[str],
    damped: Sequence[str],
    factor: float,
) -> dict[str, float] | None:
    """A change of one damping that lets one stiffness grow."""
    for other in damped:
        for turn in (math.sqrt(factor), 1 / math.sqrt(factor)):
            for name in stiff:
                trial = {
                    **gains,
                    other: gains[other] * turn,
                    name: gains[name] * factor,
                }
                if stable(trial):
                    return trial
    return None


def _growth(
    stable: Callable[[Mapping[str, float]], bool], gains: dict[str, float], name: str
) -> float:
    """By what factor one stiffness can grow on its own, up to 64."""
    low, high = 0.0, math.log(64.0)
    for _ in range(6):
        middle = (low + high) / 2
        if stable({**gains, name: gains[name] * math.exp(middle)}):
            low = middle
        else:
            high = middle
    return math.exp(low)


def _compensation(parameters: Parameters, network: Network, timing: Timing) -> float:
    """The null of the shortest delay, taken back until the loop is mean-square stable with it."""
    shortest = network.fixed_delay
    if network.jitter > 0:
        shortest = next(i for i, p in enumerate(network.delay_probabilities()) if p > 1e-3)
    user = 1 if parameters.architecture == "centralized" else 0
    alone = parameters.model(tuple(m == user for m in range(parameters.users)))
    quickest = replace(timing, delay=PathDelay.each_way(shortest))
    value = null_compensation(alone, quickest, user).value
    process = network.process()
    for _ in range(40):
        model = uniform_compensation(parameters.model(), value)
        if mean_square_radius(model, timing, lambda _: process) < 1.0 - 1e-9:
            return value
        value *= 0.9
    return 0.0


def _no_design(parameters: Parameters, network: Network, margin: float) -> str:
    kept = sorted(name for name in parameters.given if name[0] in "kb")
    what = f"Take back {', '.join(kept)}" if kept else "Lower the loss or the delay"
    return (
        f"No {parameters.architecture} gains are mean-square stable with a margin of {margin:g} "
        f"over this network (delay {network.delay:g} s, jitter {network.jitter:g} s, loss "
        f"{network.loss:g}). {what}, ask for a smaller margin, or use another architecture."
    )


def overlay(parameters: Parameters, found: Design) -> str:
    """The design as a scenario overlay (YAML) for the single-axis scenarios."""
    gains, users = found.gains, range(1, parameters.users + 1)
    lines = [
        "# Gains designed for a measured network.",
        *(f"# {name} is limited by: {cause}." for name, cause in found.limited_by.items()),
        "components:",
    ]

    def coupler(name: str, k: str, b: str) -> None:
        values = f"{{stiffness: {gains[k]:.6g}, damping: {gains[b]:.6g}}}"
        lines.append(f"  {name}: {{parameters: {values}}}")

    if parameters.architecture == "centralized":
        for m in users:
            coupler(f"coupler_{m}", f"k_{min(m, 2)}", f"b_{min(m, 2)}")
        lines.append(f"  object: {{parameters: {{compensation: {found.compensation:.6g}}}}}")
    else:
        for m in users:
            coupler(f"coupler_{m}{m}", "k_11", "b_11")
            for r in users:
                if r != m:
                    coupler(f"coupler_{m}{r}", "k_12", "b_12")
            coupler(f"coupler_o{m}", "k_o", "b_o")
            lines.append(
                f"  object_{m}: {{parameters: {{compensation: {found.compensation:.6g}}}}}"
            )
    return "\n".join(lines) + "\n"
