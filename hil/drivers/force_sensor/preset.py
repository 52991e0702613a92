"""Sensors to begin with; a bench's own calibration goes into its file."""

from __future__ import annotations

from hil.sensing.sensor_preset import LoadChannel, SensorPreset

RATED_SHARE = 0.5
"""A bridge of 2 mV/V gives half of what a 24-bit converter at gain 128 takes (4 mV/V)."""
ADC_RANGE = 2**23 - 1
NEWTON, NEWTON_METRE = 1e-3, 1e-5
"""What a count of a board that applies its sensor's calibration by itself is worth."""


def load_cell(rated: float) -> SensorPreset:
    """One bar with a strain-gauge bridge of 2 mV/V, loaded along z to ``rated`` (N)."""
    per_count = rated / (RATED_SHARE * ADC_RANGE)
    return SensorPreset(channels=(LoadChannel(force=(0.0, 0.0, per_count), full_scale=ADC_RANGE),))


def six_axis(force: float, torque: float) -> SensorPreset:
    """A board that sends mN and 10 uN.m itself, up to ``force`` (N) and ``torque`` (N.m)."""
    units = [tuple(float(row == axis) for axis in range(3)) for row in range(3)]
    along = [(x * NEWTON, y * NEWTON, z * NEWTON) for x, y, z in units]
    about = [(x * NEWTON_METRE, y * NEWTON_METRE, z * NEWTON_METRE) for x, y, z in units]
    return SensorPreset(
        channels=(
            *(LoadChannel(force=each, full_scale=round(force / NEWTON)) for each in along),
            *(LoadChannel(torque=each, full_scale=round(torque / NEWTON_METRE)) for each in about),
        )
    )


KNOWN = {
    "load_cell_10n": load_cell(10.0),
    "load_cell_50n": load_cell(50.0),
    "six_axis": six_axis(50.0, 1.0),
}
