"""A Haply's firmware on a clock of its own, asked at uneven times: what it is made of is found.

Both clocks are simulated, so that a busy machine changes nothing; the bytes are the board's own.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from cosim.base.component import Setup
from cosim.identification.excitation.controller import Excitation
from cosim.identification.nominal import Nominal
from cosim.identification.regressor import inertia_matrix
from cosim.identification.results import identify
from cosim.identification.samples import Recording
from hil.drivers.haply.emulator import HaplyBoard
from hil.drivers.haply.protocol import HaplyAxis, angles, reset, setup, torques
from hil.emulation.launch import Order, make
from hil.emulation.mechanics import HeldForm, Mechanics
from tests.support.identification.known import DEVICE, HAPLY, HOME, TICK

SHARE, LATENCY_TICKS, OFFSET = 0.02, 0.1, 3e-3
COULOMB = 0.005
OFFSETS = (0.01, -0.01)
SECONDS = 40.0
LATE = 0.1
"""Mean of how late an exchange is (ticks): now and then a tick of the board's passes twice."""
DEVICE_NUMBER = 5
AXES = [HaplyAxis(port=2), HaplyAxis(port=1)]


class Host:
    """The plan's excitation at the host's ticks."""

    def __init__(self, tick: float) -> None:
        self._parts = Excitation()
        values = Nominal.of("haply").values(HAPLY)
        parameters = {
            **{name: getattr(HAPLY, name) for name in ("proximal", "distal", "base")},
            "middle": list(HOME),
            "slow": 0.4,
            "fast": 350.0,
            "seconds": SECONDS,
            "payload": 0.0,
            "seed": 1,
            "values": values.tolist(),
        }
        self.angle, self.torque, reference = (np.zeros(2) for _ in range(3))
        self._parts.initialise(
            Setup(name="host", parameters=parameters, tick=(1, round(1 / tick)), period=1, seed=0),
            {"joint_angle": self.angle},
            {"motor_torque": self.torque, "reference": reference},
        )

    def command(self, tick: int) -> tuple[float, float]:
        self._parts.evaluate(tick)
        self._parts.step(tick)
        return float(self.torque[0]), float(self.torque[1])


def paced(payload: float) -> Recording:
    """A run of a board whose ticks lie half a tick beside the host's."""
    mechanics = Mechanics(
        payload=payload, hand=HeldForm(stiffness=0.0, damping=0.0), coulomb_friction=COULOMB
    )
    parameters = {"device": 1, "initial_tip_position": (0.019, 0.1)}
    board, link, _ = make(Order(name="haply", parameters=parameters, mechanics=mechanics))
    assert isinstance(board, HaplyBoard)
    start = board.world.angle()
    homed = [angle + error for angle, error in zip(start, OFFSETS, strict=True)]
    axes = [
        HaplyAxis(port=axis.port, offset=math.degrees(angle))
        for axis, angle in zip(AXES, homed, strict=True)
    ]
    board.receive(reset(DEVICE_NUMBER) + setup(DEVICE_NUMBER, axes))
    host, rows = Host(TICK), round((SECONDS + 5.0) / TICK)
    late = np.random.default_rng(1).exponential(LATE, rows)
    angle, torque, shown = np.zeros((rows, 2)), np.zeros((rows, 2)), homed
    for row in range(rows):
        host.angle[:] = angle[row] = shown
        torque[row] = host.command(row)
        while board.world.tick < math.floor(row + 0.5 + late[row]):
            board.world.advance()
        command = (torque[row, 0], torque[row, 1])
        (answer,) = board.receive(torques(DEVICE_NUMBER, axes, command))
        shown = [math.radians(each) for each in angles(DEVICE_NUMBER, axes, answer)]
    board.world.body.close()
    link.close()
    return Recording(
        name="paced",
        digest="0" * 64,
        date="2026-11-27",
        tick=TICK,
        ticks=np.arange(rows),
        angle=angle,
        torque=torque,
        age=np.zeros(rows, dtype=np.int64),
        status=np.full(rows, 11),
        limit=0.12,
        payload=payload,
    )


@pytest.mark.slow
def test_uneven_exchanges_with_a_board_that_does_not_wait() -> None:
    found = identify(DEVICE, [paced(0.0), paced(0.05)], [1, 1])
    made_of = Nominal.of("haply", {"coulomb_friction": COULOMB}).values(HAPLY)
    inertia = inertia_matrix(HAPLY, HOME) @ made_of[:5]
    print("\n" + "\n".join(map(str, found.estimates)))
    for number in (1, 2):
        home = inertia[number - 1, number - 1]
        assert found[f"home_{number}{number}"].value == pytest.approx(home, rel=SHARE)
        assert found[f"coulomb_{number}"].value == pytest.approx(COULOMB, rel=SHARE)
        assert found[f"offset_{number}"].value == pytest.approx(OFFSETS[number - 1], abs=OFFSET)
        assert found[f"gain_{number}"].value == pytest.approx(1.0, rel=SHARE)
    assert found["latency"].value * 1024 == pytest.approx(1.0, abs=LATENCY_TICKS)
