"""What a measurement says: round trip, jitter, loss and its bursts, order, and both ways apart."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.link.netchar.bursts import BurstyLoss, fit_bursts
from cosim.link.netchar.measurement import (
    RECEIVED,
    RELAYED,
    RETURNED,
    SENT,
    NetworkMeasurement,
    Times,
)

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
class Loss:
    """Packets that never came back; ``forward`` were lost on the way there."""

    packets: int
    fraction: float
    forward: int
    backward: int
    bursts: dict[int, int]
    """Length in packets -> how often; empty where caps or the own queue made gaps of their own."""
    gilbert_elliott: BurstyLoss | None
    """``None`` where losses come singly, as from independent draws, or are too few to tell."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Characteristics:
    """Table 1.1 of the thesis and what else a measurement shows; times in seconds.

    ``forward`` and ``backward`` are one-way times under the assumption that the fastest packet
    needed as long there as back: their difference from each other is real, a constant asymmetry is
    not in them. ``relay`` is the time at the other side, part of the round trip.

    All packets are counted. The distributions are of one packet in ``kept_one_in``, drawn at random
    from so many in a row; the shortest and the longest round trip are of all.
    """

    rate: float
    size: int
    sent: int
    returned: int
    duplicates: int
    reordered: int
    forged: int
    greetings: int
    """Messages of the handshake that came when it was over."""
    capped: int
    """Packets that the relay's caps kept back: neither lost nor measured."""
    late: int
    """Packets that came back after they were given up: neither lost nor measured."""
    late_replies: int
    """Replies to packets of an earlier measurement, which that one had counted as lost."""
    kept_one_in: int
    unsent: int
    """Packets that the own computer could not send: neither lost nor measured."""
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
    columns = measurement.kept.columns
    came = columns[:, columns[RETURNED] > 0]
    trips = forward = backward = relay = None
    asymmetry = skew = None
    if came.shape[1]:
        there, back, skew = _one_way(came)
        trips = replace(
            Distribution.of(_seconds(came[RETURNED] - came[SENT])),
            minimum=measurement.shortest * 1e-9,
            maximum=measurement.longest * 1e-9,
        )
        relay = Distribution.of(_seconds(came[RELAYED] - came[RECEIVED]))
        forward, backward = Distribution.of(there), Distribution.of(back)
        asymmetry = forward.mean - backward.mean
    return Characteristics(
        rate=measurement.rate,
        size=measurement.size,
        sent=measurement.count,
        returned=measurement.returned,
        duplicates=measurement.duplicates,
        reordered=measurement.reordered,
        forged=measurement.forged,
        greetings=measurement.greetings,
        capped=measurement.capped,
        late=measurement.late,
        late_replies=measurement.late_replies,
        kept_one_in=measurement.kept.stride,
        unsent=measurement.unsent,
        late_sends=measurement.late_sends,
        duration=(measurement.last_sent - measurement.first_sent) * 1e-9,
        round_trip=trips,
        forward=forward,
        backward=backward,
        relay=relay,
        asymmetry=asymmetry,
        clock_skew=skew,
        loss=_loss(measurement),
    )


def _one_way(came: Times) -> tuple[Floats, Floats, float | None]:
    """One-way times (s) there and back, and the skew of the other clock.

    Offset and skew come from the exchanges with the lowest tenth of round trips.
    """
    sent, returned, received, relayed = came
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


def _seconds(nanoseconds: Times) -> Floats:
    return nanoseconds.astype(np.float64) * 1e-9


def _loss(measurement: NetworkMeasurement) -> Loss:
    # Which ones the caps or the own queue kept back is not known, only how many.
    capped = min(measurement.capped, measurement.lost)
    whole = not capped and not measurement.unsent
    packets = measurement.lost - capped
    # Number and count of the first and last echo say how many between them never got there.
    forward = 0
    if measurement.relay_first is not None:
        (first, count_first), (last, count_last) = measurement.relay_first, measurement.relay_last
        kept_back = capped + measurement.unsent
        forward = min(packets, max(0, (last - first) - (count_last - count_first) - kept_back))
    return Loss(
        packets=packets,
        fraction=packets / max(1, measurement.count),
        forward=forward,
        backward=packets - forward,
        bursts=measurement.pattern.bursts if whole else {},
        gilbert_elliott=fit_bursts(measurement.pattern) if whole else None,
    )
