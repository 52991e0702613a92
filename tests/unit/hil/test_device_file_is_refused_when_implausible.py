"""A device file says what is wrong with it in a sentence; what it accepts is what was written."""

from __future__ import annotations

import math

import pytest

from cosim.base.errors import InputError
from hil.safety.conversion import TorqueDrive, VoltageDrive
from hil.safety.limits import Limits
from hil.setup.address import parse as parse_url
from hil.setup.device_file import PRESETS, load, parse, save
from hil.setup.registry import find

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
        ({"sereal": "1"}, "did you mean 'serial'"),
        ({"joints": [{}]}, "two joints"),
        ({"joints": [{"direction": 0}, {}]}, "1 or -1"),
        ({"joints": [{"counts_per_turn": 3}, {}]}, "implausible"),
        ({"joints": [{"offset": 90.0}, {}]}, "rad"),
        ({"joints": [{"drive": {"gear": -1.0}}, {}]}, "positive"),
        ({"joints": [{"drive": {"torque_constant": 0.1}}, {}]}, "needs both"),
        ({"home": [math.pi, 0.0], "geometry": {"base": 0.1}}, "cannot meet"),
        ({"geometry": {"proximal": 0}}, "positive"),
        ({"limits": {"torque": 0.2}}, "looser"),
        ({"limits": {"torque": float("nan")}}, "number"),
        ({"limits": {"ramp_time": 5.0}}, "1 to 2 s"),
        ({"limits": {"voltage": 5.0}}, "no limit 'voltage'"),
        ({"workspace": {"left": 1, "right": 0, "bottom": 0, "top": 1}}, "empty"),
        ({"estop": "yes"}, "confirmed"),
        ({"preset": "omega"}, "quanser, haply"),
        ({"driver": None}, "driver: haply"),
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
    with pytest.raises(InputError, match="cannot be read"):
        load(tmp_path / "none.yaml")


def test_drives_that_take_volts_get_the_presets_motor():
    assert isinstance(parse({"driver": "canopen"}).joints[0].drive, VoltageDrive)
    assert isinstance(parse({"driver": "odrive"}).joints[0].drive, TorqueDrive)
    assert parse({"driver": "mock"}).home is not None


def test_presets_are_the_pantograph_fmus():
    from fmus.shared.mechanism.device import presets

    geometry, dynamics = presets("GEOMETRY"), presets("DYNAMICS")
    known = {**geometry, **dynamics}
    for index, (name, preset) in enumerate(PRESETS.items()):
        assert preset["geometry"]["proximal"] == known["proximal_length"][index], name
        assert preset["geometry"]["distal"] == known["distal_length"][index], name
        assert preset["geometry"]["base"] == known["base_distance"][index], name
        assert preset["counts_per_turn"] == known["encoder_counts"][index], name


@pytest.mark.parametrize(
    ("driver", "settings", "named"),
    [
        ("haply", {"ports": 5}, r"settings\.ports"),
        ("haply", {"ports": [1, "2"]}, r"settings\.ports"),
        ("haply", {"rotation": None}, r"settings\.rotation"),
        ("haply", {"device": "five"}, r"settings\.device"),
        ("haply", {"device": math.nan}, r"settings\.device"),
        ("haply", {"device": 300}, "0 to 255"),
        ("haply", {"rotation": [1, 2]}, "0 or 1"),
    ],
)
def test_a_drivers_own_settings_are_checked_too(driver, settings, named):
    file = parse({"driver": driver, "settings": settings})
    device = find(driver)(parse_url(f"{driver}://x"), file)
    with pytest.raises(InputError, match=named):
        device.configure()
