"""The safety layer itself watches what is planned, and never has a reason to do anything."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cohaptic.described import envelope
from cosim.base.errors import InputError
from cosim.identification.excitation.design import design
from cosim.identification.nominal import Nominal
from cosim.identification.regressor import torques
from hil.device.contract import Flag
from hil.safety.layer import SafetyLayer
from hil.setup.device_file import default

TICK = 1 / 1024
SECONDS = 12.0
TIMID = default("haply").limits.replaced({"torque": 0.05, "tip_speed": 0.5})
PLANNED = {
    "haply": default("haply"),
    "quanser": default("mock"),
    "timid": replace(default("haply"), limits=TIMID),
}


def planned(file, payload=0.0):
    rest = (0.019, 0.1) if file.preset == "haply" else (0.0425, 0.2)
    home = file.linkage.angles(rest)
    limits = envelope(file)
    values = Nominal.of(file.preset).values(limits.bar, payload)
    return limits, values, home, design(limits, values, home, SECONDS)


@pytest.mark.parametrize("name", PLANNED)
def test_the_safety_layer_lets_all_of_it_through(name):
    file = PLANNED[name]
    limits, values, home, path = planned(file, 0.02)
    angle, rate, acceleration = path.sampled(np.asarray(home), TICK)
    # The friction's sides are the motion's own affair: what counts are slopes of the torque.
    commands = torques(limits.bar, angle, rate, acceleration)[:, :, :5] @ values[:5]
    layer = SafetyLayer(
        file.limits, file.linkage, tick=TICK, quantum=file.quantum, region=file.region
    )
    layer.start()
    done = Flag.NONE
    for tick, (place, command) in enumerate(zip(angle.tolist(), commands.tolist(), strict=True)):
        trip = layer.observe(tick, (place[0], place[1]), 0)
        decision = layer.limit(tick, (command[0], command[1]))
        assert trip is None
        assert decision.trip is None
        done |= decision.flags
    assert done == Flag.RAMPING
    # And it is no timid motion: one of the limits is nearly used up.
    use = limits.use((angle, rate, acceleration), values, TICK)
    assert 0.8 < max(use.values()) < 1.05


def test_limits_that_leave_no_motion_are_refused():
    file = default("haply")
    for limit, value in (("tip_speed", 0.05), ("torque", 0.006), ("dexterity", 0.9)):
        narrow = replace(file, limits=file.limits.replaced({limit: value}))
        with pytest.raises(InputError, match="no excitation stays inside"):
            planned(narrow)


def test_the_same_seed_is_the_same_motion_and_nothing_repeats():
    _, _, home, path = planned(default("haply"))
    one, again = (path.sampled(np.asarray(home), TICK)[0] for _ in range(2))
    assert np.array_equal(one, again)
    other = replace(path, seed=2).sampled(np.asarray(home), TICK)[0]
    assert not np.allclose(one, other)
    assert np.abs(one[:4] - home).max() < 1e-9
