"""What of a channel can be turned while it runs: its delay, and impairments that have a dial.

The delay and times are in seconds, whole base ticks unless a component's output says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from pydantic_core import PydanticCustomError

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.scenario.build.channel import halves
from cosim.scenario.build.timebase import Timebase
from cosim.scenario.form.fields import to_lag, to_probability
from cosim.scenario.impairments.effect import whole_ticks
from cosim.scenario.impairments.impairment import Dial, ImpairmentProblem
from cosim.scenario.impairments.registry import impairments, replaced_by
from cosim.scenario.model import Channel, Delay, Direction

WAYS = ("forward", "backward")
DELAY = "delay"
_WHOLE = ("delay", "each_way_delay", "round_trip_delay")


def dials() -> Mapping[str, Dial]:
    """Every impairment that can be turned, by its key."""
    return {name: kind.dial for name, kind in impairments().items() if kind.dial is not None}


def unit_of(name: str) -> str:
    """The unit of a dial: ``s`` or ``1``."""
    return "s" if name == DELAY else dials()[name].unit


def description_of(name: str) -> str:
    """What a dial turns: a sentence."""
    return "How long a packet is on its way" if name == DELAY else dials()[name].description


def settings(channel: Channel, path: str, value: Any, base_rate: Fraction) -> dict[str, float]:
    """What a written value of a channel's dial means, in SI units, by ``forward.delay`` and so on.

    ``path`` is a dial, with its way before it or for both; ``round_trip_delay`` and
    ``each_way_delay`` are known, too.

    Raises:
        InputError: the channel has no such dial, or the value is none of it.
    """
    where = f"{channel.name}.{path}"
    targets = _targets(channel, path)
    timebase = Timebase(base_rate)
    try:
        if unit_of(targets[0].partition(".")[2]) == "1":
            found = [to_probability(value)] * len(targets)
        else:
            lag = timebase.delay(to_lag(value), channel.period)
            two = halves(lag, channel.period) if path == "round_trip_delay" else (lag, lag)
            found = [float(delay.ticks / base_rate) for delay in two]
    except PydanticCustomError as error:
        raise InputError(f"{where}: {error.message()}") from None
    return dict(zip(targets, found, strict=False))


def reading(channel: Channel, way: str, name: str, base_rate: Fraction) -> float:
    """Where a dial stands as the scenario is written, in SI units.

    Raises:
        InputError: the channel says more of it than a number.
    """
    direction: Direction = getattr(channel, way)
    standing = [
        f"'{other}' stands in place of '{name}'"
        for other in direction.impairments
        if name in replaced_by(other)
    ]
    if standing:
        raise InputError(f"{channel.name}.{way}.{name} cannot be turned: {standing[0]}.")
    if name == DELAY:
        return float(direction.delay.ticks / base_rate)
    try:
        return dials()[name].read(direction.impairments.get(name), base_rate)
    except ImpairmentProblem as error:
        raise InputError(f"{channel.name}.{way}.{name} cannot be turned: {error}") from None


def turned(direction: Direction, standing: Mapping[str, float], base_rate: Fraction) -> Direction:
    """The direction with its dials at these values (SI units), by name."""
    effects = dict(direction.impairments)
    delay = direction.delay
    for name, value in standing.items():
        if name == DELAY:
            ticks = whole_ticks(value, base_rate)
            delay = Delay(ticks=ticks, samples=None if ticks else 0)
            continue
        effect = dials()[name].turn(direction.impairments.get(name), value, base_rate)
        effects.pop(name, None)
        if effect is not None:
            effects[name] = effect
    return replace(direction, delay=delay, impairments=effects)


def written(name: str, value: float, base_rate: Fraction) -> float | str:
    """A value of a dial as a scenario has it."""
    if unit_of(name) == "1":
        return value
    ticks = whole_ticks(value, base_rate)
    return f"{ticks} tick{'' if ticks == 1 else 's'}"


def targets_of(channel: Channel, path: str) -> tuple[str, ...]:
    """``forward.delay`` and so on of a connection's target: a dial with or without its way.

    Raises:
        InputError: the channel has no such dial.
    """
    if path in {"round_trip_delay", "each_way_delay"}:
        raise InputError(
            f"{channel.name}.{path} can be set by an event; connect to {channel.name}.delay, which "
            f"is that of each way, or to {channel.name}.forward.delay and "
            f"{channel.name}.backward.delay."
        )
    return _targets(channel, path)


def _targets(channel: Channel, path: str) -> tuple[str, ...]:
    if path in _WHOLE:
        return tuple(f"{way}.{DELAY}" for way in WAYS)
    names = {DELAY, *dials()}
    if path in names:
        return tuple(f"{way}.{path}" for way in WAYS)
    way, _, name = path.partition(".")
    if way in WAYS and name in names:
        return (path,)
    known = [*_WHOLE, *dials(), *(f"{way}.{name}" for way in WAYS for name in sorted(names))]
    fixed = name if way in WAYS else path
    if fixed in impairments():
        raise InputError(f"{channel.name}.{path} stays as it is while the scenario runs.")
    raise InputError(
        f"the channel {channel.name} has nothing called '{path}' that could be turned."
        f"{did_you_mean(path, known)}"
    )
