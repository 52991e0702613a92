"""``compensation: auto`` puts the null at the scenario's own delay where numbers belong."""

from __future__ import annotations

import pytest

from cosim.analysis import load_tuned
from cosim.base.errors import InputError
from cosim.scenario.resolved import to_yaml

FREE_MOTION, THREE = "thesis/free_motion", "thesis/three_users"


def compensation(choice, *sets):
    scenario = load_tuned(
        FREE_MOTION, (), [f"components.vr_a.parameters.compensation={choice}", *sets]
    )
    parameters = scenario.components["vr_a"].parameters
    assert "compensation" not in parameters
    return tuple(parameters[f"compensation.{axis}"] for axis in ("x", "y", "theta"))


@pytest.mark.parametrize(("round_trip", "null"), [(0, -0.877), (1, -1.844), (2, -2.811)])
def test_auto_is_the_null_of_the_full_model_at_the_scenarios_delay(round_trip, null):
    x, y, theta = compensation("auto", f"channels.lan.round_trip_delay={round_trip}")
    assert x == y == pytest.approx(null, abs=5e-4)
    assert theta < 0.0


def test_cautious_compensates_less_on_each_axis_and_the_same_in_rotation():
    auto, cautious = compensation("auto"), compensation("cautious")
    assert auto[0] < cautious[0] < 0.0
    assert auto[2] == cautious[2]


def test_a_delay_between_two_samples_is_taken_as_it_is_and_rounded_down_by_caution():
    delay = "channels.lan.round_trip_delay="
    two, late, three = (compensation("auto", f"{delay}{n}") for n in (2, "18 ticks", 3))
    assert all(b < m < a for a, m, b in zip(two, late, three, strict=True))
    assert compensation("cautious", f"{delay}18 ticks") == compensation("cautious", f"{delay}2")
    assert compensation("cautious", f"{delay}18 ticks") != compensation("cautious", f"{delay}3")


def test_the_resolved_scenario_shows_the_numbers():
    resolved = to_yaml(
        load_tuned(FREE_MOTION, (), ["components.vr_a.parameters.compensation=auto"])
    )
    assert "auto" not in resolved
    assert "compensation.x: -1.84" in resolved


def test_another_word_is_refused_with_the_place():
    with pytest.raises(InputError, match=r"compensation=automatic: .*auto or cautious"):
        load_tuned(FREE_MOTION, (), ["components.vr_a.parameters.compensation=automatic"])


def test_a_single_user_has_no_network_to_compensate():
    with pytest.raises(InputError, match="1 distributed workstation"):
        load_tuned("thesis/rigid_contact", (), ["components.vr_a.parameters.compensation=auto"])


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ("components.vr_b.parameters.predictor=linear", "vr_b predicts what it hears"),
        ("components.vr_b.parameters.predictor=intent", "vr_b predicts what it hears"),
        (
            "channels.lan={between: [station_a, station_b], rate: network, trace: [1, 2]}",
            "lan.forward has trace",
        ),
        ("components.vr_a.start.peer_weight=[0.5, 1, 1, 1, 1, 1, 1, 1]", "peer_weight of its own"),
        ("components.vr_a.parameters.peers=2", "has 2 peers"),
    ],
)
@pytest.mark.parametrize("choice", ["auto", "cautious"])
def test_what_the_models_do_not_have_is_not_compensated_by_them(choice, changed, said):
    """Linear prediction leaves a thousandth of the damping: its null for held values drives."""
    with pytest.raises(InputError, match=said):
        compensation(choice, changed)


def test_ways_of_unlike_delays_have_no_null_of_one():
    sets = ["channels.lan_ab.round_trip_delay=~", "channels.lan_ab.each_way_delay=3"]
    for choice in ("auto", "cautious"):
        given = f"components.vr_a.parameters.compensation={choice}"
        load_tuned(THREE, (), [given])
        if choice == "cautious":
            load_tuned(THREE, (), [*sets, given])
            continue
        with pytest.raises(InputError, match="after different delays"):
            load_tuned(THREE, (), [*sets, given])
