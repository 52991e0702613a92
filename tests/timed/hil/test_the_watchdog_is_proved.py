"""A board's watchdog counts once it was seen to fire: fed, starved, reported in time, noted."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.base.system.pulse import Pulse
from cosim.cli import cli
from hil.device.contract import State, Watchdog
from hil.device.device import Device
from hil.device.errors import ActivationRefused, DeviceError
from hil.drivers.mock.driver import MockDriver
from hil.safety.permission import ask
from hil.safety.safeguards import check_safeguards
from hil.setup.address import parse
from hil.setup.device_edit import save
from hil.setup.device_file import default, load
from hil.setup.watchdog_proof import prove_watchdog
from tests.support.hil.driver_bench import DRIVERS, SETUPS, Bench
from tests.support.hil.hil_bench import Puppet

GUARDED = [name for name in DRIVERS if "watchdog_proof" in SETUPS[name]["file"]]
ON_A_WIRE = [name for name in GUARDED if name != "odrive"]
"""The other one is reached over a network, which is refused anyway."""
TICK = 1 / 1024


def confirmed():
    """A person's word: what holds for hardware."""
    return ask("x", [], lambda text: "enable")


def unproved(bench: Bench, name: str, **changes):
    emulator = bench.emulator(name)
    document = {k: v for k, v in SETUPS[name]["file"].items() if k != "watchdog_proof"}
    device = bench.device(name, emulator, file=document | changes)
    device.permission = confirmed()
    return device, emulator


@pytest.mark.parametrize("name", GUARDED)
def test_it_fires_in_time_and_the_board_s_torque_was_zero_throughout(name: str, bench: Bench):
    device, emulator = unproved(bench, name)
    device.configure()
    proof = prove_watchdog(device)
    assert device.state is State.INACTIVE
    assert proof.timeout <= proof.fired_after + TICK
    assert proof.fired_after <= proof.timeout + 0.030 + TICK
    assert emulator.control.ask("state")["largest"] == 0.0


@pytest.mark.parametrize("name", ON_A_WIRE)
def test_force_is_refused_until_it_was_proved(name: str, bench: Bench):
    device, _ = unproved(bench, name)
    assert not device.watchdog.verified
    device.driver.pulse = Pulse()
    with pytest.raises(ActivationRefused, match="has not been proved"):
        check_safeguards(device)
    proved, _ = unproved(bench, name, watchdog_proof=SETUPS[name]["file"]["watchdog_proof"])
    assert proved.watchdog.verified
    check_safeguards(proved)


@pytest.mark.parametrize("name", GUARDED)
@pytest.mark.parametrize("other", [{"serial": "A17"}, {"timeout": 0.05}])
def test_the_proof_of_another_device_or_another_timeout_is_none(name, other, bench: Bench):
    proof = SETUPS[name]["file"]["watchdog_proof"] | other
    device, _ = unproved(bench, name, watchdog_proof=proof)
    assert not device.watchdog.verified


@pytest.mark.parametrize("name", GUARDED)
def test_without_consent_nothing_is_switched_on(name: str, bench: Bench):
    device, emulator = unproved(bench, name)
    device.permission = None
    device.configure()
    sent = emulator.control.ask("state")["received"]
    with pytest.raises(ActivationRefused, match="--enable-output"):
        prove_watchdog(device)
    assert emulator.control.ask("state")["received"] == sent


def test_a_watchdog_that_is_off_is_found_out(bench: Bench):
    """The endpoint numbers in the file are wrong, so nothing was switched on."""
    wrong = {"timeout": 0.02, "timeout_endpoint": 7, "enable_endpoint": 8}
    device, _ = unproved(bench, "odrive (slcan)", settings={"watchdog": wrong})
    device.configure()
    with pytest.raises(DeviceError, match="did not fire within"):
        prove_watchdog(device)


class Nervous(MockDriver):
    """Its watchdog fires at every command."""

    driver = "mock"
    watchdog = Watchdog(timeout=0.02)

    def receive(self):
        return replace(super().receive(), watchdog_fired=True)


def test_a_watchdog_that_fires_while_it_is_fed_is_no_proof():
    device = Device(Nervous, parse("mock://"), default("mock"), permission=confirmed())
    device.driver.body = Puppet()
    device.configure()
    with pytest.raises(DeviceError, match="fires while it is fed"):
        prove_watchdog(device)
    assert set(device.driver.body.torques) == {(0.0, 0.0)}


def test_a_device_without_one_says_so(bench: Bench):
    device = bench.device("haply", bench.emulator("haply"))
    device.configure()
    with pytest.raises(DeviceError, match="has no watchdog"):
        prove_watchdog(device)


def test_the_command_notes_it_in_the_device_file_and_keeps_the_rest(bench: Bench, tmp_path):
    emulator = bench.emulator("cobs")
    path = tmp_path / "finger.yaml"
    save(path, {"driver": "cobs", "home": list(emulator.home), "serial": "5573"})
    path.write_text("# the left one\n" + path.read_text())
    arguments = ["device", "check", emulator.url, "--seconds", "0.1", "--json", "--enable-output"]
    invoke = CliRunner().invoke
    with pytest.raises(InputError, match="--file"):
        invoke(cli, arguments, catch_exceptions=False, standalone_mode=False)
    arguments += ["--file", str(path)]
    with pytest.raises(ActivationRefused, match="nobody to confirm"):
        invoke(cli, arguments, catch_exceptions=False, standalone_mode=False)
    assert load(path).watchdog_proof is None
    done = invoke(cli, [*arguments, "--yes"], catch_exceptions=False, standalone_mode=False)
    said = json.loads(done.stdout)["watchdog_proof"]
    noted = load(path)
    assert noted.watchdog_proof is not None
    assert noted.watchdog_proof.date == said["date"]
    assert noted.watchdog_proof.serial == noted.serial == "5573"
    assert "# the left one" in path.read_text()
