"""The load at rest, taken as zero: refused where it varies, or is no rest."""

from __future__ import annotations

from collections.abc import Sequence

from hil.device.errors import DeviceError
from hil.sensing.sensor_preset import LoadChannel

TARE_SAMPLES = 64
TARE_SPREAD, TARE_OFFSET = 0.01, 0.25
"""Shares of a channel's range within which a load may vary, and be, while it is taken as zero."""


def tared(
    name: str, channels: Sequence[LoadChannel], rows: Sequence[Sequence[int]]
) -> tuple[float, ...]:
    """Each channel's counts at rest, from what was fit for use of ``TARE_SAMPLES`` samples.

    Raises:
        DeviceError: too few are, the load varies, or is far from the sensor's own zero.
    """
    if 2 * len(rows) < TARE_SAMPLES:
        raise DeviceError(
            f"{name} cannot be tared: only {len(rows)} of {TARE_SAMPLES} samples were fit for use"
        )
    columns = list(zip(*rows, strict=True))
    for index, (values, channel) in enumerate(zip(columns, channels, strict=True), 1):
        span, mean = max(values) - min(values), sum(values) / len(values)
        if span > TARE_SPREAD * channel.full_scale:
            raise DeviceError(
                f"{name} cannot be tared: channel {index} varies by {span} counts, more than "
                f"{TARE_SPREAD:.0%} of its range; let it be at rest"
            )
        if abs(mean - channel.zero) > TARE_OFFSET * channel.full_scale:
            raise DeviceError(
                f"{name} cannot be tared: channel {index} is at {mean:.0f} counts, more than "
                f"{TARE_OFFSET:.0%} of its range from its 'zero'; take the load off, or write "
                "'tare: false'"
            )
    return tuple(sum(values) / len(values) for values in columns)
