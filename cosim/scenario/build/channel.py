"""A written channel resolved: both directions, in base ticks and probabilities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import ceil, fsum, sqrt
from pathlib import Path
from typing import Any, cast

from cosim.base.errors import InputError, Location
from cosim.scenario.form.channel import (
    Both,
    ChannelForm,
    GilbertElliottForm,
    LateForm,
    RmsJitter,
    WeightedJitter,
)
from cosim.scenario.form.fields import Lag
from cosim.scenario.model import (
    Bernoulli,
    Delay,
    Direction,
    Duplication,
    GilbertElliott,
    Jitter,
    Reorder,
)
from cosim.base.quantity import QuantityError, quantity
from cosim.scenario.build.timebase import Timebase

MAX_STEPS = 10_000
REORDER_BY = Lag(Fraction(2), "samples")
DUPLICATE_BY = Lag(Fraction(1), "samples")
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
        InputError: a trace file cannot be read.
    """
    forward, backward = (
        _direction(form, side, timebase=timebase, period=period, folder=folder) for side in (0, 1)
    )
    return forward, backward


def _direction(
    form: ChannelForm,
    side: int,
    *,
    timebase: Timebase,
    period: int,
    folder: Callable[[str], Path],
) -> Direction:
    reorder = _late(_side(form.reorder, side), REORDER_BY, timebase, period)
    duplication = _late(_side(form.duplication, side), DUPLICATE_BY, timebase, period)
    trace, file = _trace(_side(form.trace, side), timebase, period, folder)
    return Direction(
        delay=_delays(form, timebase, period)[side],
        jitter=_jitter(_side(form.jitter, side), timebase, period),
        loss=_loss(_side(form.loss, side)),
        reorder=Reorder(probability=reorder[0], ticks=reorder[1]),
        duplication=Duplication(probability=duplication[0], ticks=duplication[1]),
        trace=trace,
        trace_file=file,
    )


def _side(written: Any, side: int) -> Any:
    """What is written for one direction; what is written once holds for both."""
    if not isinstance(written, Both):
        return written
    both = cast("Both[Any]", written)
    return both.backward if side else both.forward


def _delays(form: ChannelForm, timebase: Timebase, period: int) -> tuple[Delay, Delay]:
    if form.delay is not None:
        there, back = form.delay.forward, form.delay.backward
        return timebase.delay(there, period), timebase.delay(back, period)
    if form.each_way_delay is not None:
        each = timebase.delay(form.each_way_delay, period)
        return each, each
    total = timebase.delay(form.round_trip_delay or NO_DELAY, period)
    if total.samples is not None:
        there, back = (total.samples + 1) // 2, total.samples // 2
        return (
            Delay(ticks=there * period, samples=there),
            Delay(ticks=back * period, samples=back),
        )
    halves = ((total.ticks + 1) // 2, total.ticks // 2)
    longer, shorter = (Delay(ticks=t, samples=None if t else 0) for t in halves)
    return longer, shorter


def _jitter(written: Any, timebase: Timebase, period: int) -> Jitter:
    match written:
        case None:
            return Jitter()
        case RmsJitter(rms=rms):
            return Jitter(weights=_weights_of_rms(float(rms * timebase.base_rate)))
        case WeightedJitter(weights=weights, step=step):
            ticks = timebase.delay(step or DUPLICATE_BY, period).ticks
            total = fsum(weights)
            if total <= 0.0:
                raise ChannelProblem("jitter", "the weights are all zero.")
            if len(weights) == 1 or ticks == 0:
                return Jitter()
            scaled = abs(total - 1.0) > 1e-9
            return Jitter(step=ticks, weights=tuple(w / total if scaled else w for w in weights))
        case _:
            return _uniform_jitter(written, timebase, period)


def _uniform_jitter(lag: Lag, timebase: Timebase, period: int) -> Jitter:
    delay = timebase.delay(lag, period)
    step = period if delay.samples is not None else 1
    most = delay.ticks // step
    _check_steps(most)
    return Jitter(step=step, weights=Jitter.uniform(most)) if most else Jitter()


def _weights_of_rms(rms: float) -> tuple[float, ...]:
    """Weights of 0, 1, 2 … ticks with standard deviation ``rms`` (ticks).

    A mixture of the uniform distributions over 0..m-1 and 0..m, for the m that brackets it. A
    uniform distribution over 0..m has the variance ((m + 1)² - 1) / 12.
    """
    if rms == 0.0:
        return (1.0,)
    _check_steps(rms * sqrt(12.0))
    most = max(1, ceil(sqrt(12.0 * rms * rms + 1.0) - 1.0 - 1e-12))
    low, high = 0.0, 1.0
    for _ in range(60):
        share = (low + high) / 2.0
        low, high = (share, high) if _deviation(_mixture(most, share)) < rms else (low, share)
    return _mixture(most, high)


def _mixture(most: int, share: float) -> tuple[float, ...]:
    shorter = (1.0 - share) / most
    return (*(shorter + share / (most + 1),) * most, share / (most + 1))


def _deviation(weights: Sequence[float]) -> float:
    mean = fsum(i * weight for i, weight in enumerate(weights))
    return sqrt(fsum((i - mean) ** 2 * weight for i, weight in enumerate(weights)))


def _check_steps(most: float) -> None:
    if most > MAX_STEPS:
        raise ChannelProblem("jitter", f"it spans more than {MAX_STEPS} steps.")


def _loss(written: Any) -> Bernoulli | GilbertElliott:
    if not isinstance(written, GilbertElliottForm):
        return Bernoulli(probability=written or 0.0)
    if written.good_to_bad == written.bad_to_good == 0.0:
        raise ChannelProblem("loss", "good_to_bad and bad_to_good are both 0: the chain is stuck.")
    return GilbertElliott(
        good_to_bad=written.good_to_bad,
        bad_to_good=written.bad_to_good,
        loss_good=written.loss_good,
        loss_bad=written.loss_bad,
    )


def _late(written: Any, by: Lag, timebase: Timebase, period: int) -> tuple[float, int]:
    """How probable, and how many ticks later."""
    if isinstance(written, LateForm):
        probability, by = written.probability, written.by or by
    else:
        probability = written or 0.0
    return (probability, timebase.delay(by, period).ticks) if probability else (0.0, 0)


def _trace(
    written: Any, timebase: Timebase, period: int, folder: Callable[[str], Path]
) -> tuple[tuple[int, ...] | None, Path | None]:
    if written is None:
        return None, None
    if not isinstance(written, str):
        lags: list[Lag | None] = written
        return tuple(-1 if lag is None else timebase.delay(lag, period).ticks for lag in lags), None
    file = (folder("trace") / Path(written).expanduser()).resolve()
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "it is no UTF-8 text"
        raise ChannelProblem("trace", f"cannot read {written}: {reason}.") from None
    fates = [
        _fate(line.strip(), Location(str(file), number, 1), timebase)
        for number, line in enumerate(lines, start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not fates:
        raise ChannelProblem("trace", f"{written} has no packet in it.")
    return tuple(fates), file


def _fate(line: str, place: Location, timebase: Timebase) -> int:
    if line == "lost":
        return -1
    try:
        seconds = quantity(line, "s")
    except QuantityError:
        seconds = Fraction(-1)
    if not 0 <= seconds <= 3600:
        raise InputError(f"'{line[:40]}' is neither 'lost' nor a delay of 0 to 3600 s.", place)
    return timebase.ticks(seconds)
