"""A board gets force once its watchdog fired at this very opening, whatever its file says."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest

from cosim.base.system.supervised import Opening
from hil.device.component import DeviceComponent
from hil.device.contract import State
from hil.device.errors import DeviceError
from hil.setup import session as sessions
from hil.setup.registry import find
from hil.setup.watchdog_proof import prove_at_opening
from tests.support.hil.driver_bench import SETUPS, TICK, Bench

BOARDS = ("cobs", "odrive (slcan)", "canopen (slcan)")


def opened(bench: Bench, name: str, **changes):
    emulator = bench.emulator(name)
    file = {k: v for k, v in SETUPS[name]["file"].items() if k != "watchdog_proof"} | changes
    device = bench.device(name, emulator, file=file)
    device.configure()
    return device, emulator


@pytest.mark.parametrize("name", BOARDS)
def test_it_fires_and_the_torque_was_zero_throughout(name: str, bench: Bench):
    device, emulator = opened(bench, name)
    prove_at_opening(device)
    assert device.watchdog.protects
    assert device.state is State.INACTIVE
    assert emulator.control.ask("state")["largest"] == 0.0
    device.home()
    for tick in range(device.rest_ticks):
        device.read(tick)
        device.write(tick, (0.0, 0.0))
    device.activate()
    device.read(0)
    device.write(0, (0.0, 0.0))
    assert device.fault is None


def test_a_file_that_says_so_is_no_proof(bench: Bench):
    """The endpoint numbers in the file are wrong, so nothing was switched on."""
    wrong = {"timeout": 0.02, "timeout_endpoint": 7, "enable_endpoint": 8}
    proof = SETUPS["odrive (slcan)"]["file"]["watchdog_proof"]
    device, _ = opened(bench, "odrive (slcan)", settings={"watchdog": wrong}, watchdog_proof=proof)
    with pytest.raises(DeviceError, match="did not fire within"):
        prove_at_opening(device)


def test_an_earlier_opening_is_no_proof(bench: Bench):
    device, _ = opened(bench, "cobs")
    prove_at_opening(device)
    device.close()
    device.configure()
    assert not device.watchdog.protects


def test_without_force_nothing_is_switched_on(bench: Bench):
    device, emulator = opened(bench, "cobs")
    device.permission = None
    sent = emulator.control.ask("state")["received"]
    prove_at_opening(device)
    assert emulator.control.ask("state")["received"] == sent


def test_a_run_with_force_proves_it(bench: Bench, tmp_path: Path):
    emulator = bench.emulator("cobs")
    file = tmp_path / "finger.yaml"
    file.write_text(json.dumps({"driver": "cobs", "home": list(emulator.home)}))
    sessions.begin(sessions.Session(enable_output=True, yes=True))
    try:
        component = DeviceComponent(find("cobs"), emulator.url, {"file": str(file)})
        order = Opening(name="finger", number=0, tick=Fraction(TICK), parameters={})
        assert component.open(order).watchdog.protects
        component.close()
    finally:
        sessions.begin(sessions.Session())
