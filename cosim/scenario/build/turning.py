"""Written knobs and events resolved: their targets known, times in ticks, channels in SI units."""

from __future__ import annotations

from collections.abc import Mapping

from cosim.base.document.node import PathKey
from cosim.base.suggest import did_you_mean
from cosim.scenario.build.context import Context
from cosim.scenario.build.dials import settings
from cosim.scenario.form.fields import Lag
from cosim.scenario.model import Channel, Event, KnobRange, Reference, Value


def build_knobs(context: Context, channels: Mapping[str, Channel]) -> tuple[KnobRange, ...]:
    """Every knob, those of channels by direction."""
    knobs: list[KnobRange] = []
    for target, form in context.document.knobs.items():
        path = ("knobs", target)
        minimum, maximum = form.minimum, form.maximum
        component, _, rest = target.partition(".")
        if not _is_known(context, path, component):
            continue
        channel = channels.get(component)
        if channel is None:
            reference = Reference(component=component, path=rest)
            knobs.append(
                KnobRange(target=reference, minimum=minimum, maximum=maximum, written=path)
            )
            continue
        with context.problems.at(path):
            base_rate = context.timebase.base_rate
            known = settings(channel, rest, 0, base_rate)
            least, most = (
                {} if bound is None else settings(channel, rest, bound, base_rate)
                for bound in (minimum, maximum)
            )
            knobs += [
                KnobRange(
                    target=Reference(component=component, path=dial),
                    minimum=least.get(dial),
                    maximum=most.get(dial),
                    written=path,
                )
                for dial in known
            ]
    return tuple(knobs)


def build_events(
    context: Context, channels: Mapping[str, Channel], ticks: int, start_tick: int
) -> tuple[Event, ...]:
    """Every event, in the order of their ticks; ``ticks`` is the scenario's end.

    ``start_tick`` is its first tick, counted from time 0.
    """
    events: list[Event] = []
    for position, form in enumerate(context.document.events):
        index = context.index("events", position)
        tick = _tick(context, form.at, start_tick)
        if tick < 0:
            start = float(context.document.start_time)
            message = f"events.{index}: it lies before the run, which starts at {start:g} s."
            context.problems.add(("events", index, "at"), message)
            continue
        if tick >= ticks:
            message = (
                f"events.{index}: it is at tick {tick}, and the run ends before that, with tick "
                f"{ticks - 1}; give the scenario a longer duration, or take the event out."
            )
            context.problems.add(("events", index, "at"), message)
            continue
        for target, value in form.set_.items():
            path = ("events", index, "set", target)
            events += [
                Event(tick=tick, target=reference, value=setting, written=path)
                for reference, setting in _settings(context, channels, path, value)
            ]
    return tuple(sorted(events, key=lambda event: event.tick))


def _settings(
    context: Context, channels: Mapping[str, Channel], path: tuple[PathKey, ...], value: Value
) -> list[tuple[Reference, Value]]:
    component, _, rest = str(path[-1]).partition(".")
    if not _is_known(context, path, component):
        return []
    channel = channels.get(component)
    if channel is None:
        return [(Reference(component=component, path=rest), value)]
    with context.problems.at(path):
        found = settings(channel, rest, value, context.timebase.base_rate)
        return [
            (Reference(component=component, path=dial), setting) for dial, setting in found.items()
        ]
    return []


def _tick(context: Context, at: Lag, start_tick: int) -> int:
    """A written number of ticks counts from the start, a time from 0."""
    if at.unit == "ticks":
        return int(at.amount)
    return context.timebase.ticks(at.amount) - start_tick


def _is_known(context: Context, path: tuple[PathKey, ...], name: str) -> bool:
    """Whether there is a component or channel of that name; a wrong one has been reported."""
    known = {*context.names("components"), *context.names("channels")}
    if name not in known and context.is_whole("components") and context.is_whole("channels"):
        hint = did_you_mean(name, known)
        message = f"there is no component or channel '{name}'.{hint}"
        context.problems.add(path, message, at_key=True)
    return name in context.document.components or name in context.document.channels
