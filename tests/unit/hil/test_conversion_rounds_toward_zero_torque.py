"""What is sent never exceeds what was allowed, in any direction, with any bias or gear."""

from __future__ import annotations

import struct
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from hil.safety.conversion import TorqueDrive, VoltageDrive

torques = st.floats(-1.0, 1.0)
directions = st.sampled_from([1, -1])


@settings(deadline=None)
@given(torques, directions, st.floats(0.5, 20.0))
def test_float_drive(torque, direction, gear):
    drive = TorqueDrive(direction=direction, gear=gear)
    code = drive.encode(torque)
    assert struct.unpack("<f", struct.pack("<f", code))[0] == code
    sent = drive.decode(code)
    assert abs(sent) <= abs(torque)
    assert sent * torque >= 0.0
    assert abs(sent - torque) <= 3e-7 * abs(torque) + 1e-40


@settings(deadline=None)
@given(
    torques,
    st.builds(
        VoltageDrive,
        direction=directions,
        gear=st.floats(0.5, 20.0),
        torque_constant=st.floats(0.01, 0.2),
        amplifier=st.floats(0.1, 2.0),
        bias=st.floats(-0.5, 0.5),
    ),
    st.sampled_from([(-32767, 32767), (0, 4095), (-2048, 2047)]),
)
def test_voltage_drive(torque, drive, codes):
    drive = replace(drive, low_code=codes[0], high_code=codes[1])
    code = drive.encode(torque)
    assert codes[0] <= code <= codes[1]
    sent = drive.decode(code)
    assert abs(sent) <= abs(torque) * (1 + 1e-12)
    assert sent * torque >= 0.0
    quantum = abs(drive.volts_per_code * drive.torque_per_volt)
    largest = abs(drive.torque_per_volt) * (10.0 - abs(drive.bias))
    assert abs(sent - torque) <= 2 * quantum or abs(sent) >= largest - 2 * quantum
    assert drive.decode(drive.encode(0.0)) == 0.0
