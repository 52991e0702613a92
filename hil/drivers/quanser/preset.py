"""The 2-DOF pantograph that Quanser made: direct drive, current amplifiers behind a DAC.

Lengths, counts, torque constant and amplifier are published; the motor's continuous torque and the
amplifier's largest current are assumed. ``fmus/shared/mechanism/device_parameters.h`` has the same.
"""

from __future__ import annotations

from hil.safety.linkage import Linkage
from hil.setup.preset import Motor, Preset

QUANSER = Preset(
    linkage=Linkage(proximal=0.100, distal=0.165, base=0.085),
    counts_per_turn=20000,
    motor=Motor(peak_torque=0.255, continuous_torque=0.09, peak_current=7.0),
    drive={"torque_constant": 0.0364, "amplifier": 0.5},
    rest=(0.0425, 0.2),
    model={"device": 0},
)
