"""Every driver, against an emulator in another process, tick by tick: normal operation."""

from __future__ import annotations

from math import pi, sin

import pytest

from hil.device.contract import ZERO, State, Status
from hil.device.errors import ActivationRefused
from hil.emulation.plant import SimulatedPantograph
from hil.setup.emulator_proof import doubt
from tests.support.hil.driver_bench import DRIVERS, SETUPS, Bench, Rig

every_driver = pytest.mark.parametrize("rig", DRIVERS, indirect=True)
every_name = pytest.mark.parametrize("name", DRIVERS)


@every_driver
def test_angles_and_torques_pass_the_wire(rig: Rig):
    device = rig.device
    exchanged = rig.exchange(2000, lambda tick, _: (0.02, -0.01) if tick > 5 else (0.0, 0.0))
    assert device.state is State.ACTIVE, device.fault_sentence()
    measured, sent = exchanged[-1]
    truth = rig.truth()
    resolution = 2 * device.file.quantum
    for axis in (0, 1):
        assert measured.joint_angle[axis] == pytest.approx(truth["angle"][axis], abs=resolution)
        assert truth["torque"][axis] == pytest.approx(sent.torque[axis], abs=1e-12 + 1e-6)
    assert sent.torque == pytest.approx((0.02, -0.01), abs=2e-4)
    moved = abs(measured.joint_angle[0] - exchanged[0][0].joint_angle[0])
    assert moved > 5 * device.file.quantum, "the torque has to move the handle"
    assert {m.sample_age for m, _ in exchanged[2:]} == {0}
    assert measured.status == Status.HOMED | Status.ACTIVE | Status.OUTPUT_ENABLED


@pytest.mark.parametrize(
    "rig", [*DRIVERS, "canopen (pipelined)", "cia402 (pipelined)"], indirect=True
)
def test_what_is_measured_is_the_model_with_the_declared_latency_and_resolution(rig: Rig):
    """The torques that were sent, given to the same model here, explain every measured angle."""
    device = rig.device
    setup = SETUPS[device.driver.driver]
    exchanged = rig.exchange(1500, lambda tick, _: (0.03 * sin(tick / 40), 0.02) if tick else ZERO)
    assert device.state is State.ACTIVE, device.fault_sentence()
    twin = SimulatedPantograph(setup["parameters"])
    angles = [twin.angle()]
    for _, sent in exchanged:
        twin.step(sent.torque)
        angles.append(twin.angle())
    errors = dict.fromkeys(range(3), 0.0)
    for latency in errors:
        for tick in range(3, len(exchanged)):
            measured, expected = exchanged[tick][0].joint_angle, angles[tick - latency]
            worst = max(abs(measured[axis] - expected[axis]) for axis in (0, 1))
            errors[latency] = max(errors[latency], worst)
    declared = device.driver.latency_of(device.address)
    assert errors[declared] <= 1.01 * device.file.quantum
    assert min(errors, key=errors.__getitem__) == declared


@every_name
def test_without_a_permission_the_wire_carries_zeros(name: str, bench: Bench):
    rig = bench.rig(name, output=False)
    exchanged = rig.exchange(300, (0.005, 0.0))
    assert exchanged[-1][1].limited[0] > 0.0
    assert rig.truth()["torque"] == [0.0, 0.0]


@every_name
def test_an_unhomed_device_measures_and_refuses(name: str, bench: Bench):
    device = bench.device(name, bench.emulator(name))
    device.configure()
    for tick in range(80):
        device.read(tick)
        device.write(tick, (0.1, 0.1))
    with pytest.raises(ActivationRefused, match="homed"):
        device.activate()


@every_name
def test_the_emulator_proves_itself(name: str, bench: Bench):
    emulator = bench.emulator(name)
    device = bench.device(name, emulator)
    device.configure()
    assert doubt(device) is None
    other = bench.device(name, bench.emulator(name))
    other.configure()
    options = {**device.address.options, "emulator": other.address.options["emulator"]}
    object.__setattr__(device.address, "options", options)
    assert doubt(device) is not None, "another emulator's side channel proves nothing"


@every_name
def test_a_handle_that_moves_is_not_activated(name: str, bench: Bench):
    rig = bench.rig(name, activate=False)
    for step in range(40):
        rig.emulator.control.ask("shift", by=(step * 0.0004, 0.0))
        rig.exchange(1)
    with pytest.raises(ActivationRefused, match="rest"):
        rig.device.activate()


@every_driver
def test_deactivation_and_close_leave_zero(rig: Rig):
    rig.exchange(400, (0.008, 0.008))
    assert rig.truth()["torque"] != [0.0, 0.0]
    rig.device.close()
    assert rig.truth()["torque"] == [0.0, 0.0]


@every_driver
def test_a_session_of_close_and_configure_again(rig: Rig):
    rig.exchange(50, (0.005, 0.0))
    rig.device.close()
    rig.device.configure()
    assert not rig.device.homed
    rig.device.home()
    rig.exchange(100)
    rig.device.activate()
    rig.exchange(50, (0.005, 0.0))
    assert rig.device.state is State.ACTIVE


def test_resolution_is_the_encoders():
    assert SETUPS["haply"]["file"]["preset"] == "haply"
    assert 2 * pi / 4880 == pytest.approx(1.2875e-3, rel=1e-3)
