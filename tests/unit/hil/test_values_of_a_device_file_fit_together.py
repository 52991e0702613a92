"""A device file is judged as a whole: limits, ratings, gears, constants, workspace and home."""

from __future__ import annotations

from dataclasses import fields

import pytest

from cosim.base.errors import InputError, InputErrors
from hil.safety.limits import Limits, hard_ceilings
from hil.setup.device_file import parse

VOLTS = {"torque_constant": 0.0364, "amplifier": 0.5}
HARD = hard_ceilings()
ROOM = {"left": -0.05, "right": 0.12, "bottom": 0.08, "top": 0.24}
WIDE = {**ROOM, "left": -0.3}


def card(**drive):
    return {"driver": "quanser", "joints": [{"drive": drive}, {}]}


@pytest.mark.parametrize("name", [field.name for field in fields(Limits)])
def test_no_reason_loosens_a_limit_beyond_its_hard_ceiling(name):
    """Four times the default, a quarter of the dexterity; the ramp lasts a second at least."""
    hard = getattr(HARD, name)
    assert hard == {"dexterity": 0.15 / 4, "ramp_time": 1.0}.get(name, getattr(Limits(), name) * 4)
    looser = hard / 1.01 if name in {"dexterity", "ramp_time"} else hard * 1.01
    document = {
        "driver": "mock",
        "motor": {"peak_torque": 5, "continuous_torque": 5},
        "loosened": {name: "I want to"},
    }
    assert getattr(parse({**document, "limits": {name: hard}}).limits, name) == hard
    with pytest.raises(InputError, match=f"hard ceiling|{name}.*at least 1 s"):
        parse({**document, "limits": {name: looser}})


@pytest.mark.parametrize(
    ("document", "says"),
    [
        (card(torque_constant=36.4e-6), "torque_constant.* at least 0.001"),
        (card(torque_constant=0.00364), "asks for 41.2 A of a motor that takes 7 A"),
        (card(amplifier=0.05), "asks for 82.4 V beyond the bias, and the DAC has 10 V"),
        (card(low=-5, high=5), r"asks for 8.24 V .* 'limits: \{torque: 0.091\}'"),
        (card(bias=9.0), "bias: 9 V .* near the middle"),
        (card(low=0, high=10, bias=0), "bias: 0 V .* near the middle"),
        (card(low=5, high=-5), "low < high"),
        (card(low_code=5, high_code=5), "low_code < high_code"),
        (card(gear=0.001), "gear.* at least 1"),
        (card(gear=1000), "gear.* at most 100"),
        (
            {"driver": "cobs", "limits": {"torque": 0.4}, "loosened": {"torque": "stronger"}},
            "more than the motor of joint 1 is rated for",
        ),
        (
            {"driver": "cobs", "motor": {"continuous_torque": 0.05}},
            "continuous_torque: 0.08 N.m is more than the motor of joint 1",
        ),
        ({"driver": "haply", "joints": [{"drive": VOLTS}, {}]}, "is given the motor's torque"),
        ({"driver": "mock", "workspace": WIDE}, "write why under 'loosened: {workspace"),
        (
            {"driver": "mock", "workspace": ROOM, "loosened": {"workspace": "roomy"}},
            "does not reach beyond the default",
        ),
        (
            {
                "driver": "odrive",
                "workspace": {**ROOM, "left": 0.8, "right": 0.9},
                "loosened": {"workspace": "over there"},
            },
            "out of the linkage's reach",
        ),
        ({"driver": "mock", "home": [2.28, 0.85], "workspace": {**ROOM, "top": 0.1}}, "outside"),
        ({"driver": "mock", "home": [2.2, 2.2], "geometry": {"base": 0.01}}, "singular"),
    ],
)
def test_what_does_not_fit_together_is_refused(document, says):
    with pytest.raises(InputError, match=says):
        parse(document)


def test_what_fits_together_is_taken():
    assert parse(card(bias=0.5)).joints[0].drive.bias == 0.5
    unipolar = parse({**card(low=0, high=10, bias=5), "limits": {"torque": 0.09}})
    assert unipolar.joints[0].drive.low == 0.0
    strong = {"driver": "cobs", "limits": {"torque": 0.4}, "loosened": {"torque": "stronger"}}
    assert parse({**strong, "motor": {"peak_torque": 0.5}}).limits.torque == 0.4
    geared = {**strong, "joints": [{"drive": {"gear": 2}}, {"drive": {"gear": 2}}]}
    assert parse(geared).motor.peak_torque == 0.255
    wide = parse({"driver": "mock", "workspace": WIDE, "loosened": {"workspace": "measured"}})
    assert wide.loosened == {"workspace": "measured"}


def test_a_word_that_is_no_truth_value_is_refused_rather_than_true():
    document = {"driver": "canopen", "settings": {"absolute": "no"}}
    with pytest.raises(InputError, match="true or false, not the text 'no'; write false"):
        parse(document)
    assert parse({"driver": "canopen", "settings": {"absolute": False}}).settings.absolute is False


def test_all_of_it_is_said_at_once():
    with pytest.raises(InputErrors) as caught:
        parse(
            {
                **card(bias=9.0, amplifier=0.05),
                "home": [2.28, 0.85],
                "workspace": {**ROOM, "top": 0.1},
            }
        )
    assert len(caught.value.errors) >= 3
