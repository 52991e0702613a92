"""Changing any key of a device file, of a driver's settings or of a device URL has an effect.

The keys are taken from the forms of every registered driver: one without a case here fails the
first test. What a device does is seen on a puppet, what a driver asks for on its wire.
"""

from __future__ import annotations

import json
from fractions import Fraction
from math import pi, sin
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner

from cosim.base.errors import CohapticError
from cosim.cli import cli
from hil.device.component import DeviceComponent
from hil.device.device import Device
from hil.device.warnings import warnings_of
from hil.drivers.mock.driver import MockDriver
from hil.safety.form import SafetyForm
from hil.safety.permission import dead_man
from hil.safety.safeguards import check_safeguards
from hil.setup.address import parse
from hil.setup.device_file import DeviceFile
from hil.setup.device_file import parse as parse_file
from hil.setup.device_form import DeviceFileForm
from hil.setup.registry import find, names
from tests.support.forms.walk import Key, keys_of
from tests.support.forms.wiretap import wiretap
from tests.support.hil.hil_bench import ALLOWED, REST_ANGLE, Puppet, mock, run

DRIVERS = [kind for name in names() if not (kind := find(name)).measures_only]
"""A sensor's keys have a test of their own."""
KEYS = keys_of(
    DeviceFileForm,
    SafetyForm,
    *(driver.settings for driver in DRIVERS),
    *(driver.options for driver in DRIVERS),
)

SLOW = Fraction(1, 512)
HALF = 0.04
LIMITS: dict[str, float] = {
    "torque": 0.1,
    "continuous_torque": HALF,
    "peak_time": 0.5,
    "slew": 1.0,
    "tip_speed": 0.3,
    "joint_speed": 3.0,
    "dexterity": 0.5,
    "ramp_time": 2.0,
}
LOOSE = {name: value * 1.2 for name, value in (("torque", 0.15), ("continuous_torque", 0.07))}
LOOSE |= {"peak_time": 3.0, "slew": 80.0, "tip_speed": 1.5, "joint_speed": 30.0}
LOOSE |= {"dexterity": 0.1, "ramp_time": 1.2}
VOLTS = {
    "torque_constant": 0.0364,
    "amplifier": 0.5,
    "low": -10.0,
    "high": 10.0,
    "low_code": -400,
    "high_code": 400,
}
ROOM = {"left": -0.05, "right": 0.12, "bottom": 0.08, "top": 0.25}
PROOF = {"date": "2026-03-01", "timeout": 0.02, "fired_after": 0.03, "serial": "7"}


def joints(**keys: Any) -> dict[str, Any]:
    return {"joints": [keys, {}]}


def drive(**keys: Any) -> dict[str, Any]:
    return joints(drive={**VOLTS, **keys})


DEVICE: dict[Key, tuple[dict[str, Any], dict[str, Any]]] = {
    ("DeviceFileForm", "driver"): ({}, {"driver": "haply"}),
    ("DeviceFileForm", "preset"): ({"preset": "quanser"}, {"preset": "haply"}),
    ("DeviceFileForm", "serial"): ({"serial": "7"}, {"serial": "8"}),
    ("DeviceFileForm", "date"): ({"date": "2026-03-01"}, {"date": "2026-03-02"}),
    ("DeviceFileForm", "estop"): ({"estop": "none"}, {"estop": "confirmed"}),
    ("DeviceFileForm", "geometry"): ({}, {"geometry": {"distal": 0.16}}),
    ("DeviceFileForm", "joints"): ({}, joints(direction=-1)),
    ("DeviceFileForm", "home"): ({}, {"home": [REST_ANGLE[0] + 0.1, REST_ANGLE[1]]}),
    ("DeviceFileForm", "limits"): ({}, {"limits": {"torque": 0.05}}),
    ("DeviceFileForm", "loosened"): (
        {"limits": {"torque": 0.2}, "loosened": {"torque": "rated so"}},
        {"limits": {"torque": 0.2}, "loosened": {"torque": "measured so"}},
    ),
    ("DeviceFileForm", "workspace"): ({}, {"workspace": {**ROOM, "top": 0.21}}),
    ("DeviceFileForm", "motor"): ({}, {"motor": {"peak_torque": 0.1}}),
    **{
        ("MotorForm", name): (drive(), {**drive(), "motor": {name: value}})
        for name, value in (
            ("peak_torque", 0.1),
            ("continuous_torque", 0.05),
            ("peak_current", 3.0),
        )
    },
    ("LoosenedForm", "workspace"): (
        {"workspace": {**ROOM, "left": -0.2}, "loosened": {"workspace": "measured so"}},
        {"workspace": {**ROOM, "left": -0.2}, "loosened": {"workspace": "built so"}},
    ),
    ("DeviceFileForm", "watchdog_proof"): ({}, {"watchdog_proof": PROOF}),
    **{
        ("GeometryForm", name): ({}, {"geometry": {name: value}})
        for name, value in (("proximal", 0.11), ("distal", 0.16), ("base", 0.08))
    },
    ("JointForm", "direction"): ({}, joints(direction=-1)),
    ("JointForm", "offset"): ({}, joints(offset=0.2)),
    ("JointForm", "counts_per_turn"): ({}, joints(counts_per_turn=4000)),
    ("JointForm", "drive"): ({}, drive()),
    **{
        ("DriveForm", name): (drive(), drive(**{name: value}))
        for name, value in {
            "direction": -1,
            "gear": 3.0,
            "torque_constant": 0.05,
            "amplifier": 0.6,
            "bias": 0.013,
            "low": -9.0,
            "high": 9.0,
            "low_code": -300,
            "high_code": 300,
        }.items()
    },
    **{
        ("WorkspaceForm", name): ({"workspace": ROOM}, {"workspace": {**ROOM, name: value}})
        for name, value in (("left", 0.042), ("right", 0.043), ("bottom", 0.199), ("top", 0.201))
    },
    **{("LimitsForm", name): ({}, {"limits": {name: value}}) for name, value in LIMITS.items()},
    **{
        ("LoosenedForm", name): (
            {"limits": {name: value}, "loosened": {name: "rated so"}},
            {"limits": {name: value}, "loosened": {name: "measured so"}},
        )
        for name, value in LOOSE.items()
    },
    **{
        ("WatchdogProofForm", name): (
            {"serial": "7", "watchdog_proof": PROOF},
            {"serial": "7", "watchdog_proof": {**PROOF, name: value}},
        )
        for name, value in (
            ("date", "2026-03-02"),
            ("timeout", 0.03),
            ("fired_after", 0.04),
            ("serial", "8"),
        )
    },
}

HAPLY, SLCAN = "haply:///dev/none", "slcan:///dev/none"
ODRIVE, CANOPEN = "odrive+socketcan://none0", "canopen+socketcan://none0"
DRIVES = "cia402+socketcan://none0"
QUANSER_CARD, NI, MOTEUS = "quanser://q8_usb/0", "nidaqmx://Dev1", "moteus:///dev/none"
NODES = [{"node": 1}, {"node": 2}]
ENDPOINTS = {"timeout": 0.02, "timeout_endpoint": 5, "enable_endpoint": 6}

OPTIONS: dict[Key, tuple[str, str]] = {
    **{
        (form, "emulator"): (f"{url}?emulator=/one", f"{url}?emulator=/two")
        for form, url in (
            ("UrlOptions", "mock://"),
            ("SerialOptions", "cobs:///dev/none"),
            ("HaplyOptions", HAPLY),
            ("OdriveOptions", ODRIVE),
            ("CanopenOptions", CANOPEN),
            ("Cia402Options", DRIVES),
            ("QuanserOptions", QUANSER_CARD),
            ("NidaqmxOptions", NI),
            ("MoteusOptions", MOTEUS),
        )
    },
    **{
        (form, "lockstep"): (f"{url}?emulator=/one", f"{url}?emulator=/one&lockstep=1")
        for form, url in (
            ("UrlOptions", "mock://"),
            ("SerialOptions", "cobs:///dev/none"),
            ("HaplyOptions", HAPLY),
            ("OdriveOptions", ODRIVE),
            ("CanopenOptions", CANOPEN),
            ("Cia402Options", DRIVES),
            ("QuanserOptions", QUANSER_CARD),
            ("NidaqmxOptions", NI),
            ("MoteusOptions", MOTEUS),
        )
    },
    ("SerialOptions", "baud"): ("cobs:///dev/none", "cobs:///dev/none?baud=9600"),
    ("SerialOptions", "wait"): ("cobs:///dev/none", "cobs:///dev/none?wait=2"),
    ("HaplyOptions", "wait"): (HAPLY, f"{HAPLY}?wait=1.5"),
    ("HaplyOptions", "baud"): (HAPLY, f"{HAPLY}?baud=9600"),
    ("HaplyOptions", "ports"): (HAPLY, f"{HAPLY}?ports=3,4"),
    **{
        (form, name): (url, f"{url}?{name}={value}")
        for form, url in (
            ("OdriveOptions", ODRIVE),
            ("CanopenOptions", CANOPEN),
            ("Cia402Options", DRIVES),
        )
        for name, value in (("bitrate", 500000), ("budget", 0.001), ("nodes", "3,4"))
    },
    ("OdriveOptions", "sleep_after_open"): (
        f"odrive+{SLCAN}",
        f"odrive+{SLCAN}?sleep_after_open=1",
    ),
    ("CanopenOptions", "sleep_after_open"): (
        f"canopen+{SLCAN}",
        f"canopen+{SLCAN}?sleep_after_open=1",
    ),
    ("Cia402Options", "sleep_after_open"): (
        f"cia402+{SLCAN}",
        f"cia402+{SLCAN}?sleep_after_open=1",
    ),
    ("CanopenOptions", "pipelined"): (CANOPEN, f"{CANOPEN}?pipelined=1"),
    ("Cia402Options", "pipelined"): (DRIVES, f"{DRIVES}?pipelined=1"),
    ("QuanserOptions", "encoders"): (QUANSER_CARD, f"{QUANSER_CARD}?encoders=2,3"),
    ("QuanserOptions", "outputs"): (QUANSER_CARD, f"{QUANSER_CARD}?outputs=2,3"),
    ("NidaqmxOptions", "counters"): (NI, f"{NI}?counters=2,3"),
    ("NidaqmxOptions", "outputs"): (NI, f"{NI}?outputs=2,3"),
    ("MoteusOptions", "ids"): (MOTEUS, f"{MOTEUS}?ids=5,6"),
    ("MoteusOptions", "budget"): (MOTEUS, f"{MOTEUS}?budget=0.01"),
}

SETTINGS: dict[Key, tuple[str, dict[str, Any], dict[str, Any]]] = {
    ("DeviceFileForm", "settings"): (HAPLY, {}, {"device": 6}),
    ("HaplySettings", "ports"): (HAPLY, {}, {"ports": [3, 4]}),
    ("HaplySettings", "rotation"): (HAPLY, {}, {"rotation": [0, 1]}),
    ("HaplySettings", "device"): (HAPLY, {}, {"device": 6}),
    ("OdriveSettings", "current_limit"): (ODRIVE, {}, {"current_limit": 5}),
    ("OdriveSettings", "watchdog"): (ODRIVE, {}, {"watchdog": ENDPOINTS}),
    ("OdriveSettings", "firmware"): (
        ODRIVE,
        {"watchdog": ENDPOINTS},
        {"firmware": "0.5", "watchdog": {"timeout": 0.02}},
    ),
    **{
        ("OdriveWatchdog", name): (
            ODRIVE,
            {"watchdog": ENDPOINTS},
            {"watchdog": {**ENDPOINTS, name: value}},
        )
        for name, value in (("timeout", 0.03), ("timeout_endpoint", 7), ("enable_endpoint", 8))
    },
    **{
        ("Cia402Settings", name): (DRIVES, {}, {name: value})
        for name, value in (
            ("nodes", [3, 4]),
            ("mode", 4),
            ("rpdo_timer", False),
            ("heartbeat", 9),
            ("watchdog", 50),
            ("timeout", 1),
        )
    },
    ("CanopenSettings", "nodes"): (CANOPEN, {}, {"nodes": [1, 2]}),
    ("CanopenSettings", "encoders"): (CANOPEN, {}, {"encoders": NODES}),
    ("CanopenSettings", "outputs"): (CANOPEN, {}, {"outputs": NODES}),
    ("CanopenSettings", "absolute"): (CANOPEN, {}, {"absolute": True}),
    ("CanopenSettings", "preset"): (CANOPEN, {}, {"preset": False}),
    ("CanopenSettings", "heartbeat"): (CANOPEN, {}, {"heartbeat": 9}),
    ("CanopenSettings", "watchdog"): (CANOPEN, {}, {"watchdog": 50}),
    ("CanopenSettings", "timeout"): (CANOPEN, {}, {"timeout": 1}),
    **{
        ("ObjectForm", name): (
            CANOPEN,
            {"encoders": NODES},
            {"encoders": [{"node": 1, name: value}, {"node": 2}]},
        )
        for name, value in (("node", 3), ("object", 0x6804), ("channel", 2))
    },
    ("QuanserSettings", "digital_outputs"): (QUANSER_CARD, {}, {"digital_outputs": 4}),
    ("QuanserSettings", "watchdog"): (QUANSER_CARD, {}, {"watchdog": 0.05}),
    ("VendorSettings", "watchdog"): (MOTEUS, {}, {"watchdog": 0.05}),
    ("WatchdogForm", "timeout"): (MOTEUS, {}, {"watchdog": {"timeout": 0.05}}),
}
MOVES = {"GeometryForm", "JointForm", "DriveForm", "WorkspaceForm", "LimitsForm"}
"""Forms of which being shown is not enough: each key changes torques, angles or faults."""
SAFETY = {("SafetyForm", name): value for name, value in LIMITS.items()}


def test_every_key_has_a_case() -> None:
    assert DEVICE.keys() | OPTIONS.keys() | SETTINGS.keys() | SAFETY.keys() == KEYS


@pytest.mark.parametrize("key", sorted(DEVICE), ids=".".join)
def test_a_key_of_a_device_file_changes_what_the_device_does_or_says(key, tmp_path) -> None:
    one, two = ({"driver": "mock", **values} for values in DEVICE[key])
    if key[0] in MOVES:
        assert exchanges(parse_file(one)) != exchanges(parse_file(two))
    else:
        assert effect(one, tmp_path / "one") != effect(two, tmp_path / "two")


def test_the_same_device_file_has_the_same_effect(tmp_path) -> None:
    document = {"driver": "mock", "serial": "7", "watchdog_proof": PROOF, **drive()}
    assert effect(document, tmp_path / "one") == effect(document, tmp_path / "two")


@pytest.mark.parametrize("key", sorted(SAFETY), ids=".".join)
def test_a_limit_of_the_scenario_changes_what_every_device_does(key) -> None:
    plain = DeviceComponent(MockDriver, "mock://", {}).file
    tighter = DeviceComponent(MockDriver, "mock://", {}, {key[1]: SAFETY[key]}).file
    assert exchanges(plain) != exchanges(tighter)


@pytest.mark.parametrize("key", sorted(SETTINGS), ids=".".join)
def test_a_setting_changes_what_goes_over_the_wire(key) -> None:
    url, one, two = SETTINGS[key]

    def said(settings: dict[str, Any]) -> Any:
        with pytest.MonkeyPatch.context() as patch:
            return wiretap(patch, url, {"driver": parse(url).driver, "settings": settings})

    assert said(one) == said(one)
    assert said(one) != said(two)


@pytest.mark.parametrize("key", sorted(OPTIONS), ids=".".join)
def test_an_option_changes_what_goes_over_the_wire(key) -> None:
    def said(url: str) -> Any:
        with pytest.MonkeyPatch.context() as patch:
            return wiretap(patch, url, {"driver": parse(url).driver})

    one, two = OPTIONS[key]
    assert said(one) == said(one)
    assert said(one) != said(two)


def effect(document: dict[str, Any], folder: Any) -> Any:
    """What the device does, what it warns of, and what ``cohaptic check`` says of its file."""
    folder.mkdir()
    path = folder / "bench.yaml"
    path.write_text(json.dumps(document))
    scenario = folder / "bench_scenario.yaml"
    device = {"url": "mock://", "file": str(path)}
    scenario.write_text(
        json.dumps(
            {"cohaptic": 1, "duration": 1, "components": {"d": {"device": device, "rate": 1024}}}
        )
    )
    said = CliRunner().invoke(cli, ["check", str(scenario)])
    try:
        file = parse_file(document)
    except CohapticError as error:
        return str(error)
    return (
        exchanges(file) if file.driver == "mock" else "another driver",
        warnings_of(mock(Puppet(), file=file)) if file.driver == "mock" else [],
        guarded(file),
        str(said.output or said.exception).replace(str(folder), ""),
    )


def guarded(file: DeviceFile) -> Any:
    """Whether a board without a watchdog of its own would be allowed to produce force."""
    document = {"driver": "cobs", "serial": file.serial}
    if file.estop_confirmed:
        document["estop"] = "confirmed"
    if file.watchdog_proof is not None:
        proof = file.watchdog_proof
        document["watchdog_proof"] = {name: getattr(proof, name) for name in PROOF}
    device = Device(
        find("haply" if file.watchdog_proof is None else "cobs"),
        parse("haply:///dev/none" if file.watchdog_proof is None else "cobs:///dev/none"),
        parse_file(document | ({} if file.watchdog_proof else {"driver": "haply"})),
        permission=dead_man("a bench", lambda: True),
        pulse=SimpleNamespace(),
    )
    try:
        check_safeguards(device)
    except CohapticError as error:
        return str(error)
    return device.driver.watchdog


def exchanges(file: DeviceFile) -> list[Any]:
    """A hand holds, moves, jerks and stretches a device that is commanded to push."""
    return [
        phase(file, 1720, lambda _: (0.0, 0.0), lambda tick: 1 if tick % 152 < 100 else -1),
        phase(file, 960, moving, lambda _: 1),
        phase(file, 100, lambda tick: (0.008 * max(0, tick - 60), 0.0), lambda _: 0),
        phase(file, 300, lambda tick: (-0.002 * tick, 0.002 * tick), lambda _: 1),
    ]


def moving(tick: int) -> tuple[float, float]:
    """Ever faster to and fro, once force has come up."""
    late = max(0, tick - 800) / 160
    return (0.3 * late * sin(2 * pi * 3 * late), 0.0)


def phase(file: DeviceFile, ticks: int, path: Any, push: Any) -> Any:
    """Torques, tips and faults of a device whose joints are moved along a path (rad)."""
    puppet = Puppet(REST_ANGLE)
    device = Device(MockDriver, parse("mock://"), file, tick=SLOW, permission=ALLOWED)
    device.driver.body = puppet
    device.driver.serial = lambda: "7"
    try:
        device.configure()
        device.home()
        run(device, 40, start=-40)
        device.activate()
    except CohapticError as error:
        return str(error)
    shown: list[Any] = [device.safety.tip]
    for tick in range(ticks):
        turned = path(tick)
        puppet.place = (REST_ANGLE[0] + turned[0], REST_ANGLE[1] + turned[1])
        measured = device.read(tick)
        command = 0.0 if tick == 0 else 0.5 * push(tick)
        sent = device.write(tick, (command, -command))
        shown.append((measured.joint_angle, measured.count, sent.torque, sent.flags))
    return shown, device.state
