"""Designed gains are mean-square stable with their margin, and say what limits them."""

from __future__ import annotations

from fractions import Fraction

import pytest
from ruamel.yaml import YAML

from cosim.base.errors import InputError
from cosim.theory.chance.mean_square import mean_square_radius
from cosim.theory.chance.network import Network
from cosim.theory.chance.packets import bernoulli
from cosim.theory.design.overlay import overlay
from cosim.theory.design.search import Design, design
from cosim.theory.models.parameters import CHAPTER_5, Architecture, Parameters
from cosim.theory.stability.margins import scaled

T_C, T_T = Fraction(1, 1024), Fraction(1, 128)


def designed(
    architecture: Architecture, network: Network, margin: float = 0.25, **given: float
) -> tuple[Parameters, Design]:
    parameters = Parameters(architecture, given, CHAPTER_5[architecture])
    return parameters, design(parameters, network, T_C, margin, explain=True)


@pytest.fixture(scope="module")
def remote() -> tuple[Parameters, Design]:
    return designed("centralized", Network(T_T, 0.001, 0.0, 0.02))


def test_the_design_keeps_its_margin_and_little_more(remote: tuple[Parameters, Design]) -> None:
    parameters, found = remote
    model = parameters.replaced(found.gains).model()

    def radius(stiffness: float, damping: float) -> float:
        return mean_square_radius(
            scaled(model, stiffness, damping), found.timing, lambda d: bernoulli(0.02, d)
        )

    assert all(radius(k, b) < 1 for k in (1.0, 1.25) for b in (1.0, 1.25))
    assert found.corners[found.worst] > 0.99


def test_every_corner_is_stable_and_the_worst_is_named(remote: tuple[Parameters, Design]) -> None:
    _, found = remote
    assert max(found.corners.values()) == found.corners[found.worst] < 1
    assert {"nobody holds it", "a sample of delay less", "loss and jitter"} <= found.corners.keys()
    # A server's box that nobody holds has nothing but the compensation: any would drive it.
    assert found.compensation == 0


def test_copies_that_damp_each_other_are_compensated_as_far_as_every_corner_allows() -> None:
    _, found = designed("distributed", Network(T_T, 0.001, 0.0, 0.02))
    assert found.compensation < -0.5
    assert max(found.corners.values()) > 0.99


def test_the_remote_coupler_is_limited_by_the_network_and_the_local_one_by_the_control_rate(
    remote: tuple[Parameters, Design],
) -> None:
    _, found = remote
    assert found.limited_by["k_1"] == "control rate"
    assert found.limited_by["k_2"] in {"delay", "network rate"}
    assert found.gains["k_1"] > 10 * found.gains["k_2"]


def test_the_overlay_is_yaml_for_the_single_axis_scenario(
    remote: tuple[Parameters, Design],
) -> None:
    parameters, found = remote
    components = YAML(typ="safe").load(overlay(parameters, found))["components"]
    assert set(components) == {"coupler_1", "coupler_2", "object"}
    assert components["coupler_2"]["parameters"]["stiffness"] == pytest.approx(found.gains["k_2"])
    assert components["object"]["parameters"]["compensation"] == 0


def test_a_given_gain_is_kept_and_distributed_renders_stiffer(
    remote: tuple[Parameters, Design],
) -> None:
    given = {"b_11": 10.0, "b_12": 3.0, "b_o": 5.0, "k_o": 300.0}
    parameters, found = designed("distributed", Network(T_T, 0.001, 0.0, 0.0), **given)
    assert found.gains["k_o"] == 300.0
    assert set(found.limited_by) == {"k_11", "k_12"}
    assert found.gains["k_11"] > 10 * remote[1].gains["k_2"]
    text = overlay(parameters, found)
    assert {"coupler_12", "coupler_21", "coupler_o2", "object_1"} <= set(
        YAML(typ="safe").load(text)["components"]
    )


def test_jitter_spreads_over_whole_samples() -> None:
    assert Network(T_T, 0.00122, 0.0003, 0.0).delay_probabilities() == pytest.approx([0, 1])
    spread = Network(T_T, 0.012, 0.004, 0.0).delay_probabilities()
    assert sum(spread) == pytest.approx(1)
    assert spread[0] == 0
    assert spread[2] > spread[1] > spread[4] > 0
    assert Network(T_T, 0.0, 0.0, 0.0).fixed_delay == 0


def test_unstable_requests_say_what_to_change() -> None:
    with pytest.raises(InputError, match="Take back k_1"):
        designed("centralized", Network(T_T, 0.0, 0.0, 0.0), k_1=200000.0)
    with pytest.raises(InputError, match="multiple of the network rate"):
        designed("centralized", Network(Fraction(1, 100), 0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="margin"):
        designed("centralized", Network(T_T, 0.0, 0.0, 0.0), margin=-1.0)
    with pytest.raises(InputError, match="connects nobody"):
        Network(T_T, 0.0, 0.0, 1.0)
    with pytest.raises(InputError, match="cannot be negative"):
        Network(T_T, -1.0, 0.0, 0.0)
