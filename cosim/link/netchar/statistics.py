"""What a measurement says: round trip, jitter, loss and its bursts, order, and both ways apart."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.link.netchar.probe import NetworkMeasurement

PERCENTILES = (50.0, 90.0, 99.0, 99.9)
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Distribution:
    """Of times in seconds; ``rms_jitter`` is the standard deviation."""

    mean: float
    rms_jitter: float
    minimum: float
    maximum: float
    percentiles: dict[str, float]

    @classmethod
    def of(cls, values: Floats) -> Distribution:
        """Of at least one value."""
        found = np.percentile(values, PERCENTILES)
        return cls(
            mean=float(values.mean()),
            rms_jitter=float(values.std()),
            minimum=float(values.min()),
            maximum=float(values.max()),
            percentiles={f"{p:g}": float(v) for p, v in zip(PERCENTILES, found, strict=True)},
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class BurstyLoss:
    """A Gilbert–Elliott channel: probabilities per packet, good state without loss."""

    good_to_bad: float
    bad_to_good: float
    loss_bad: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Loss:
    """Packets that never came back; ``forward`` were lost on the way there."""

    packets: int
    fraction: float
    forward: int
    backward: int
    bursts: dict[int, int]
    """Length in packets -> how often; empty where the relay's caps made gaps of their own."""
    gilbert_elliott: BurstyLoss | None
    """``None`` where losses come singly, as from independent draws, or are too few to tell."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Characteristics:
    """Table 1.1 of the thesis and what else a measurement shows; times in seconds.

    ``forward`` and ``backward`` are one-way times under the assumption that the fastest packet
    needed as long there as back: their difference from each other is real, a constant asymmetry is
    not in them. ``relay`` is the time at the other side, part of the round trip.
    """

    rate: float
    size: int
    sent: int
    returned: int
    duplicates: int
    reordered: int
    forged: int
    capped: int
    """Packets that the relay's caps kept back: neither lost nor measured."""
    late_replies: int
    """Replies to packets of an earlier measurement, which that one had counted as lost."""
    late_sends: int
    duration: float
    round_trip: Distribution | None
    forward: Distribution | None
    backward: Distribution | None
    relay: Distribution | None
    asymmetry: float | None
    """Mean one-way time there less back, beyond the unseen constant part."""
    clock_skew: float | None
    loss: Loss

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)


def characterise(measurement: NetworkMeasurement) -> Characteristics:
    """Everything that one measurement says."""
    came = measurement.returned > 0
    order = np.array(measurement.order, dtype=np.int64)
    reordered = int(np.sum(order < np.maximum.accumulate(order))) if len(order) else 0
    sent = measurement.sent
    trips = forward = backward = relay = None
    asymmetry = skew = None
    if came.any():
        there, back, skew = _one_way(measurement, came)
        trips = Distribution.of(_seconds(measurement.returned[came] - sent[came]))
        relay = Distribution.of(_seconds(measurement.relayed[came] - measurement.received[came]))
        forward, backward = Distribution.of(there), Distribution.of(back)
        asymmetry = forward.mean - backward.mean
    return Characteristics(
        rate=measurement.rate,
        size=measurement.size,
        sent=measurement.count,
        returned=int(came.sum()),
        duplicates=measurement.duplicates,
        reordered=reordered,
        forged=measurement.forged,
        capped=measurement.capped,
        late_replies=measurement.late_replies,
        late_sends=measurement.late_sends,
        duration=float(sent[-1] - sent[0]) * 1e-9 if measurement.count > 1 else 0.0,
        round_trip=trips,
        forward=forward,
        backward=backward,
        relay=relay,
        asymmetry=asymmetry,
        clock_skew=skew,
        loss=_loss(measurement, came),
    )


def _one_way(
    measurement: NetworkMeasurement, came: NDArray[np.bool_]
) -> tuple[Floats, Floats, float | None]:
    """One-way times (s) there and back, and the skew of the other clock.

    Offset and skew come from the exchanges with the lowest tenth of round trips.
    """
    sent, returned = measurement.sent[came], measurement.returned[came]
    received, relayed = measurement.received[came], measurement.relayed[came]
    base_there = int(received[0] - sent[0])
    there = _seconds(received - sent - base_there)
    back = _seconds(returned - relayed + base_there)
    trips = there + back
    offsets = (there - back) / 2.0
    seconds = _seconds(sent - sent[0])
    fast = trips <= np.quantile(trips, 0.1)
    skew = None
    line: Floats = np.full(len(seconds), float(offsets[fast].mean()))
    if fast.sum() >= 8 and np.ptp(seconds[fast]) >= 2.0:
        spread = seconds[fast] - seconds[fast].mean()
        skew = float(spread @ offsets[fast] / (spread @ spread))
        line = line + skew * (seconds - float(seconds[fast].mean()))
    return there - line, back + line, skew


def _seconds(nanoseconds: NDArray[np.int64]) -> Floats:
    return nanoseconds.astype(np.float64) * 1e-9


def _loss(measurement: NetworkMeasurement, came: NDArray[np.bool_]) -> Loss:
    missing = ~came
    # Which ones the caps kept back is not known, only how many.
    capped = min(measurement.capped, int(missing.sum()))
    packets = int(missing.sum()) - capped
    # Number and count of the first and last echo say how many between them never got there.
    forward = 0
    if measurement.relay_first is not None:
        (first, count_first), (last, count_last) = measurement.relay_first, measurement.relay_last
        forward = min(packets, max(0, (last - first) - (count_last - count_first) - capped))
    edges = np.flatnonzero(np.diff(np.concatenate(([0], missing.view(np.int8), [0]))))
    lengths = edges[1::2] - edges[::2]
    sizes, counts = np.unique(lengths, return_counts=True)
    return Loss(
        packets=packets,
        fraction=packets / max(1, measurement.count),
        forward=forward,
        backward=packets - forward,
        bursts={} if capped else {int(s): int(c) for s, c in zip(sizes, counts, strict=True)},
        gilbert_elliott=None if capped else fit_bursts(missing),
    )


def fit_bursts(lost: NDArray[np.bool_]) -> BurstyLoss | None:
    """Gilbert's model fitted to a sequence of losses, or ``None`` where they look independent.

    Source: Gilbert (1960), "Capacity of a burst-noise channel", from P(1), P(1|1) and
    P(111) / (P(101) + P(111)); where those give no probabilities, the two-state chain that loses
    everything in its bad state, whose estimates are counts of transitions.
    """
    count = len(lost)
    losses = int(lost.sum())
    if losses < 10 or losses > count - 10:
        return None
    overall = losses / count
    pairs = int(np.sum(lost[:-1] & lost[1:]))
    after_loss = pairs / max(1, int(lost[:-1].sum()))
    # Independent draws would give ``overall``; three standard errors more is a burst.
    if after_loss - overall < 3.0 * np.sqrt(overall * (1.0 - overall) / losses):
        return None
    with_both = int(np.sum(lost[:-2] & lost[1:-1] & lost[2:]))
    with_ends = int(np.sum(lost[:-2] & lost[2:]))
    simple = BurstyLoss(
        good_to_bad=int(np.sum(~lost[:-1] & lost[1:])) / max(1, int((~lost[:-1]).sum())),
        bad_to_good=1.0 - after_loss,
        loss_bad=1.0,
    )
    if with_ends < 30:
        return simple
    a, b, c = overall, after_loss, with_both / with_ends
    below = 2.0 * a * c - b * (a + c)
    stay = (a * c - b * b) / below if below else 0.0
    if not b < stay < 1.0:
        return simple
    loss_bad = b / stay
    bad_to_good = 1.0 - stay
    good_to_bad = a * bad_to_good / (loss_bad - a) if loss_bad > a else 0.0
    if not (0.0 < good_to_bad < 1.0 and loss_bad < 1.0):
        return simple
    return BurstyLoss(good_to_bad=good_to_bad, bad_to_good=bad_to_good, loss_bad=loss_bad)
