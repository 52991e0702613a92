"""A device file says what is wrong with it in a sentence; what it accepts is what was written."""

from __future__ import annotations

import math

import pytest

from cosim.base.errors import InputError, InputErrors
from hil.safety.conversion import TorqueDrive, VoltageDrive
from hil.safety.limits import Limits
from hil.setup.device_edit import save
from hil.setup.device_file import load, parse
from hil.setup.registry import find, find_preset

GOOD = {
    "cohaptic_device": 1,
    "driver": "haply",
    "serial": "5573",
    "date": "2026-03-01",
    "estop": "confirmed",
    "home": [2.4, 0.7],
    "joints": [{"direction": -1, "offset": 0.1, "counts_per_turn": 4880}, {}],
    "limits": {"torque": 0.1},
}


def test_a_file_survives_being_written_and_read(tmp_path):
    save(tmp_path / "device.yaml", GOOD)
    file = load(tmp_path / "device.yaml")
    assert file.joints[0].direction == -1
    assert file.joints[1].counts_per_turn == 4880
    assert file.limits.torque == 0.1
    assert file.home == (2.4, 0.7)
    assert file.estop_confirmed
    assert file.date == "2026-03-01"


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"sereal": "1"}, "Did you mean serial"),
        ({"joints": [{}]}, "joints: this list must have at least 2 items"),
        ({"joints": [{"direction": 0}, {}]}, "1 or -1"),
        ({"joints": [{"counts_per_turn": 3}, {}]}, "at least 16"),
        ({"joints": [{"offset": 90.0}, {}]}, "rad"),
        ({"joints": [{"drive": {"gear": -1.0}}, {}]}, "gear: -1.0 .* at least 1"),
        ({"joints": [{"drive": {"gear": 0.001}}, {}]}, "gear: 0.001 .* at least 1"),
        ({"joints": [{"drive": {"torque_constant": 0.1}}, {}]}, "belongs to a drive that takes v"),
        ({"home": [math.pi, 0.0], "geometry": {"base": 0.1}}, "cannot meet"),
        ({"home": [3.2, 0.0]}, "outside the workspace"),
        ({"geometry": {"proximal": 0}}, "at least 0.005 m"),
        ({"geometry": {"proximal": 70}}, "at most 1 m"),
        ({"limits": {"torque": 0.2}}, "looser"),
        ({"limits": {"torque": float("nan")}}, "number"),
        ({"limits": {"ramp_time": 5.0}}, "at most 2 s"),
        ({"limits": {"voltage": 5.0}}, "unknown key 'voltage' in limits"),
        ({"workspace": {"left": 1, "right": 0, "bottom": 0, "top": 1}}, "empty"),
        ({"estop": "yes"}, "confirmed"),
        ({"preset": "omega"}, "no preset 'omega'; there are haply, quanser"),
        ({"driver": "haptly"}, "did you mean 'haply'"),
        ({"cohaptic_device": 2}, "1, not 2"),
        ({"cohaptic_device": "1"}, "1, not the text '1'"),
        ({"date": "1st of March"}, "is no date; write it as 2026-03-01"),
        ({"date": "2026-13-01"}, "is no date"),
        ({"geometry": {"proximal": "100 N"}}, "does not convert to m"),
        ({"geometry": {"proximal": True}}, "true is no length"),
        ({"loosened": {"torque": "no need"}}, "not looser than the default"),
        ({"loosened": {"torqe": "stall"}}, "Did you mean torque"),
        ({"joints": [{"drive": {"bias": 2.5}}, {}]}, "takes volts"),
        ({"serial": True}, "no serial number"),
        ({"driver": None}, "driver: it has no value"),
    ],
)
def test_an_implausible_value_is_refused_with_a_sentence(tmp_path, change, says):
    with pytest.raises(InputError, match=says):
        parse({**GOOD, **change})


def test_a_looser_limit_needs_a_reason_and_keeps_it():
    file = parse({**GOOD, "limits": {"torque": 0.123}, "loosened": {"torque": "rated stall"}})
    assert file.limits.torque == 0.123
    assert file.loosened == {"torque": "rated stall"}
    assert Limits().is_looser("dexterity", 0.1)
    assert not Limits().is_looser("dexterity", 0.2)


def test_a_broken_file_names_itself(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text("a: [")
    with pytest.raises(InputError, match=r"bad\.yaml"):
        load(path)
    with pytest.raises(InputError, match=r"cannot read .*none\.yaml: No such file"):
        load(tmp_path / "none.yaml")


def test_drives_that_take_volts_get_the_presets_motor():
    assert isinstance(parse({"driver": "canopen"}).joints[0].drive, VoltageDrive)
    assert isinstance(parse({"driver": "odrive"}).joints[0].drive, TorqueDrive)
    assert parse({"driver": "mock"}).home is not None


def test_presets_are_the_pantograph_fmus():
    from fmus.shared.mechanism.device import presets

    known = {**presets("GEOMETRY"), **presets("DYNAMICS")}
    for index, name in enumerate(("quanser", "haply")):
        preset = find_preset(name, find("mock"))
        assert preset.model == {"device": index}
        assert preset.linkage.proximal == known["proximal_length"][index], name
        assert preset.linkage.distal == known["distal_length"][index], name
        assert preset.linkage.base == known["base_distance"][index], name
        assert preset.counts_per_turn == known["encoder_counts"][index], name
    quanser = find_preset("quanser", find("mock"))
    assert quanser.motor.peak_torque == known["torque_limit"][0]
    assert quanser.motor.peak_current == known["current_limit"][0]


@pytest.mark.parametrize(
    ("driver", "settings", "named"),
    [
        ("haply", {"ports": 5}, r"settings\.ports"),
        ("haply", {"ports": [1, "2"]}, r"settings\.ports"),
        ("haply", {"rotation": None}, r"settings\.rotation"),
        ("haply", {"device": "five"}, r"settings\.device"),
        ("haply", {"device": math.nan}, r"settings\.device"),
        ("haply", {"device": 300}, "at most 255"),
        ("haply", {"rotation": [1, 2]}, "0 or 1"),
    ],
)
def test_a_drivers_own_settings_are_checked_too(driver, settings, named):
    with pytest.raises(InputError, match=named):
        parse({"driver": driver, "settings": settings})


def test_settings_of_other_drivers_are_unknown():
    with pytest.raises(InputError, match=r"'port' in settings\. Did you mean ports"):
        parse({"driver": "haply", "settings": {"port": [1, 2]}})
    with pytest.raises(InputError, match="unknown key 'watchdog' in settings"):
        parse({"driver": "cobs", "settings": {"watchdog": {"timeout": 0.02}}})
    with pytest.raises(InputError, match="written with a 'timeout' only"):
        parse({"driver": "odrive", "settings": {"watchdog": {"enable_endpoint": 7}}})


def test_everything_that_is_wrong_is_said_at_once_each_with_its_place(tmp_path):
    path = tmp_path / "bench.yaml"
    path.write_text(
        "cohaptic_device: 3\ndriver: haply\ndate: yesterday\n"
        "geometry:\n  proximal: 100 N\n  distul: 0.1\nsettings: {ports: [1, 9]}\n"
    )
    with pytest.raises(InputErrors) as caught:
        load(path)
    places = [str(error.location).removeprefix(str(path)) for error in caught.value.errors]
    assert places == [":1:18", ":3:7", ":5:13", ":6:3", ":7:19"]


def test_quantities_have_units(tmp_path):
    path = tmp_path / "bench.yaml"
    path.write_text(
        "driver: haply\ngeometry: {proximal: 100 mm, distal: 16.5 cm, base: 85 mm}\n"
        "home: [90 deg, 40 deg]\nlimits: {torque: 100 mN.m, joint_speed: 60 rpm}\n"
    )
    file = load(path)
    assert (file.linkage.proximal, file.linkage.distal, file.linkage.base) == (0.1, 0.165, 0.085)
    assert file.home == (math.pi / 2, pytest.approx(math.radians(40)))
    assert file.limits.torque == 0.1
    assert file.limits.joint_speed == pytest.approx(2 * math.pi)
