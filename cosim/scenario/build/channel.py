"""A written channel resolved: both directions, in base ticks and probabilities."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

from cosim.scenario.build.timebase import Timebase
from cosim.scenario.form.channel import ChannelForm
from cosim.scenario.form.fields import Lag
from cosim.scenario.impairments.effect import Effect
from cosim.scenario.impairments.impairment import ImpairmentProblem, Setting
from cosim.scenario.impairments.registry import impairments
from cosim.scenario.model import Delay, Direction

NO_DELAY = Lag(Fraction(0), "samples")


class ChannelProblem(ValueError):
    """A setting of a channel that cannot be used; ``key`` says which."""

    def __init__(self, key: str, message: str) -> None:
        self.key = key
        super().__init__(message)


def directions(
    form: ChannelForm, timebase: Timebase, period: int, folder: Callable[[str], Path]
) -> tuple[Direction, Direction]:
    """Forward and backward of a channel with ``period`` ticks to a sample.

    ``folder`` gives the folder that a relative file of a key starts from.

    Raises:
        ChannelProblem: a setting cannot be used.
        InputError: a file that is named cannot be used.
    """
    effects: tuple[dict[str, Effect], dict[str, Effect]] = {}, {}
    for name, kind in impairments().items():
        setting = Setting(timebase, period, lambda name=name: folder(name))
        for side in (0, 1):
            written = form.written(name, side)
            try:
                effect = None if written is None else kind.resolve(written, setting)
            except ImpairmentProblem as error:
                raise ChannelProblem(name, str(error)) from None
            if effect is not None:
                effects[side][name] = effect
    forward, backward = (
        Direction(delay=delay, impairments=found)
        for delay, found in zip(_delays(form, timebase, period), effects, strict=True)
    )
    return forward, backward


def _delays(form: ChannelForm, timebase: Timebase, period: int) -> tuple[Delay, Delay]:
    if form.delay is not None:
        there, back = form.delay.forward, form.delay.backward
        return timebase.delay(there, period), timebase.delay(back, period)
    if form.each_way_delay is not None:
        each = timebase.delay(form.each_way_delay, period)
        return each, each
    return halves(timebase.delay(form.round_trip_delay or NO_DELAY, period), period)


def halves(total: Delay, period: int) -> tuple[Delay, Delay]:
    """A round trip there and back: forward gets the larger half."""
    if total.samples is not None:
        there, back = (total.samples + 1) // 2, total.samples // 2
        return (
            Delay(ticks=there * period, samples=there),
            Delay(ticks=back * period, samples=back),
        )
    parts = ((total.ticks + 1) // 2, total.ticks // 2)
    longer, shorter = (Delay(ticks=t, samples=None if t else 0) for t in parts)
    return longer, shorter
