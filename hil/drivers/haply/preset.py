"""The Haply 2DIY, version 3: lengths and counts are published, and where its board saturates.

What its motors hold for ever is assumed.
"""

from __future__ import annotations

from hil.safety.linkage import Linkage
from hil.setup.preset import Motor, Preset

HAPLY = Preset(
    linkage=Linkage(proximal=0.070, distal=0.090, base=0.038),
    counts_per_turn=4880,
    motor=Motor(peak_torque=0.123, continuous_torque=0.08),
    limits={"torque": 0.12},
    rest=(0.019, 0.1),
    model={"device": 1},
)
