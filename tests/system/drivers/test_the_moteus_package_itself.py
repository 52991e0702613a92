"""The official ``moteus`` package between our driver and servos that it never met, over a pty.

Run with ``uv run --group vendors pytest``.
"""

from __future__ import annotations

from fractions import Fraction

import pytest

from hil.device.contract import ZERO, State
from hil.device.device import Device
from hil.drivers.moteus.driver import MoteusDriver
from hil.safety.permission import emulated
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from tests.support.hil.moteus_servos import Servos

pytest.importorskip("moteus")
TICK = Fraction(1, 1024)


@pytest.fixture
def servos():
    made = Servos()
    yield made
    made.close()


@pytest.fixture
def device(servos: Servos):
    file = parse_file({"driver": "moteus", "home": list(servos.home)})
    made = Device(
        MoteusDriver,
        parse(f"moteus://{servos.path}?ids=1,2&budget=20"),
        file,
        tick=TICK,
        permission=emulated("servos of ours", None),
    )
    made.configure()
    yield made
    made.close()


def exchange(device: Device, ticks: int, torque=ZERO):
    done = []
    for tick in range(ticks):
        measured = device.read(tick)
        done.append((measured, device.write(tick, torque)))
    return done


def active(device: Device) -> None:
    device.home()
    exchange(device, 70)
    assert device.state is State.INACTIVE, device.fault_sentence()
    device.activate()
    exchange(device, 3)


def test_torque_out_angles_in_and_a_stop_at_the_end(device: Device, servos: Servos):
    assert device.watchdog.verified, "the servos stopped by themselves while it was opened"
    assert servos.ask()["largest"] == 0.0
    active(device)
    sent = exchange(device, 150, (0.01, -0.01))[-1][1]
    truth = servos.ask()
    assert device.state is State.ACTIVE, device.fault_sentence()
    assert truth["modes"] == [10, 10]
    assert truth["torque"] == pytest.approx(sent.torque, abs=1e-7)
    assert sent.torque[0] > 0.0
    measured = device.read(0).joint_angle
    assert measured == pytest.approx(servos.ask()["angle"], abs=1e-5), "as fine as a float32"
    device.close()
    assert servos.ask()["modes"] == [0, 0]
    assert servos.ask()["torque"] == (0.0, 0.0)


def test_a_host_that_falls_silent_is_noticed_by_the_servos_and_then_by_the_host(
    device: Device, servos: Servos
):
    active(device)
    exchange(device, 100, (0.01, -0.01))
    assert servos.ask(ticks=15)["modes"] == [10, 10]
    truth = servos.ask(ticks=10)
    assert truth["modes"] == [11, 11]
    assert truth["torque"] == (0.0, 0.0)
    exchange(device, 1, (0.01, -0.01))
    assert device.state is State.FAULT
    assert "mode 11" in device.fault_sentence()
    exchange(device, 5)
    assert servos.ask()["modes"] == [0, 0], "stopped"
