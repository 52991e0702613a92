"""What the options and the scenario say of a loop changes the answer, or is refused by name."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.cli.theory.support.run_options import is_path
from cosim.scenario.form.document import Document
from cosim.scenario.load import read

DISTRIBUTED = ("--scenario", "single_axis_distributed")


def answer(*arguments: str) -> dict[str, Any]:
    done = CliRunner().invoke(cli, ["theory", *arguments, "--json"], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def refusal(*arguments: str) -> str:
    with pytest.raises(InputError) as caught:
        CliRunner().invoke(
            cli, ["theory", *arguments], catch_exceptions=False, standalone_mode=False
        )
    return str(caught.value)


def test_a_base_rate_changes_what_a_tick_is() -> None:
    ends = "between: [station_1, station_2], rate: network"
    late = f"channels.lan={{{ends}, delay: {{forward: 20 ticks, backward: 0}}}}"
    loop = ("radius", *DISTRIBUTED, "--set", late)
    slow, fast = answer(*loop), answer(*loop, "--set", "base_rate=2048 Hz")
    assert fast["spectral_radius"] != pytest.approx(slow["spectral_radius"], rel=1e-6)
    half = late.replace("20 ticks", "10 ticks")
    assert fast["spectral_radius"] == pytest.approx(
        answer("radius", *DISTRIBUTED, "--set", half)["spectral_radius"], rel=1e-9
    )
    assert fast["period"] == slow["period"] == 1 / 128
    # The closed forms read whole samples: 20 of the longer ticks are three, of the shorter two.
    read = ("passivity", *DISTRIBUTED, "--device-damping", "3", "--set", late)
    assert answer(*read, "--set", "base_rate=2048 Hz")["architecture"] == "distributed"


def test_who_holds_is_asked_of_closed_forms_alone() -> None:
    loop = ("damping", "--architecture", "distributed")
    alone, everyone = answer(*loop), answer(*loop, "--all-hands")
    assert everyone["damping"] != pytest.approx(alone["damping"], rel=1e-3)
    assert "as the scenario says" in refusal("damping", *DISTRIBUTED, "--all-hands")


def test_a_delay_or_a_computation_delay_needs_something_to_delay(tmp_path: Path) -> None:
    one = ("radius", "--scenario", "single_user")
    for form in ("--round-trip-delay", "--each-way-delay", "--forward-delay"):
        assert "no channel" in refusal(*one, form, "3")
    late = answer(*one, "--computation-delay", "2")["spectral_radius"]
    assert late != pytest.approx(answer(*one)["spectral_radius"], rel=1e-6)
    free = tmp_path / "free.yaml"
    free.write_text(
        "cohaptic: 1\ntitle: Free\nduration: 1 s\nrates: {control: 1024 Hz}\n"
        "components:\n  body: {fmu: hand, rate: control}\n",
        encoding="utf-8",
    )
    assert "neither virtual couplers" in refusal(
        "radius", "--scenario", str(free), "--computation-delay", "2"
    )


def test_a_single_user_has_no_ratio() -> None:
    assert "no network" in refusal("radius", "--architecture", "single", "--ratio", "4")
    assert "no scenario's" in refusal("radius", "--scenario", "single_user", "--ratio", "4")


DESIGN = ("design", "--architecture", "distributed", "--round-trip-delay", "1")


def test_a_design_knows_the_computation_delay() -> None:
    plain, late = answer(*DESIGN), answer(*DESIGN, "--computation-delay", "2", "--confirm")
    assert late["gains"]["k_11"] < 0.8 * plain["gains"]["k_11"]
    assert max(late["simulated_corners"].values()) < 1
    for name, radius in late["simulated_corners"].items():
        assert radius == pytest.approx(late["corners"][name], abs=1e-6), name


def test_a_delay_that_is_said_leaves_the_scenarios_loss_and_jitter() -> None:
    lossy = ("design", *DISTRIBUTED, "--set", "channels.lan.loss=0.1", "--margin", "0.1")
    said = answer(*lossy, "--round-trip-delay", "1")
    assert "loss and jitter" in said["corners"]


def test_a_design_takes_no_bursts_and_no_trace() -> None:
    bursts = "channels.lan.loss={good_to_bad: 0.05, bad_to_good: 0.5}"
    assert "loses packets in bursts" in refusal("design", *DISTRIBUTED, "--set", bursts)
    trace = "channels.lan={between: [station_1, station_2], rate: network, trace: [1, 2]}"
    assert "trace" in refusal("design", *DISTRIBUTED, "--set", trace)


@pytest.mark.parametrize("command", [("design",), ("stiffness",), ("map",), ("passivity",)])
def test_what_is_turned_on_the_way_has_no_closed_form(command: tuple[str, ...]) -> None:
    more = {
        "passivity": ("--device-damping", "3"),
        "map": ("--vary", "k_11", "--range", "1:9", "--vary", "k_12", "--range", "1:9"),
    }.get(command[0], ())
    assert "is turned at tick" in refusal(*command, "--scenario", "single_axis_turned", *more)


def test_a_compensation_in_words_is_that_of_the_run() -> None:
    auto = [f"components.vr_{which}.parameters.compensation=auto" for which in "ab"]
    sets = [part for text in auto for part in ("--set", text)]
    found = answer("stiffness", "--scenario", "two_users_box", *sets)
    assert found["parameters"]["b_c1"] == pytest.approx(-1.844, abs=1e-3)


def test_what_no_run_has_is_not_confirmed() -> None:
    assert "nothing that b_h1 could be" in refusal(*DESIGN, "--set", "b_h=2", "--confirm")
    walled = ("--set", "b_w=5", "--computation-delay", "1", "--confirm")
    assert "wall has no computation delay" in refusal(*DESIGN, *walled)


def test_a_map_of_three_users_has_the_delays_that_are_said() -> None:
    """Round a ring of three the split counts, not the sum alone."""
    plane = ("--vary", "k_11", "--range", "2000:2001", "--vary", "k_12", "--range", "1:1500")
    loop = ("map", "--architecture", "distributed", "--users", "3", *plane, "--points", "12")
    one_way = answer(*loop, "--forward-delay", "8", "--backward-delay", "0")
    for row, stable in enumerate(one_way["stable"]):
        k_12 = one_way["vertical"][row]
        found = answer(
            *("radius", "--architecture", "distributed", "--users", "3", "--forward-delay", "8"),
            *("--backward-delay", "0", "--set", "k_11=2000", "--set", f"k_12={k_12}"),
        )
        assert found["stable"] == bool(stable[0]), k_12


@pytest.mark.parametrize("name", ["single_axis_distributed", "two_users_box"])
def test_what_a_channel_draws_is_said_and_what_was_recorded_refused(name: str) -> None:
    ends = ", ".join(read(name).built().channels["lan"].between)
    loop = ("passivity", "--scenario", name, "--device-damping", "3", "--set")
    for effect in ("loss=0.1", "jitter=1", "reorder=0.1"):
        said = CliRunner().invoke(cli, ["theory", *loop, f"channels.lan.{effect}"]).stderr
        assert "are left out here" in said
    doubled = CliRunner().invoke(cli, ["theory", *loop, "channels.lan.duplication=0.1"]).stderr
    assert "are left out here" not in doubled
    trace = f"channels.lan={{between: [{ends}], rate: network, trace: [1, 2]}}"
    assert "lan.forward has trace" in refusal(*loop, trace)


@pytest.mark.parametrize("key", sorted(Document.model_fields))
def test_every_key_of_a_scenario_is_one_of_it(key: str) -> None:
    assert is_path(f"{key}=~")


def test_a_start_and_a_list_of_events_may_be_set_in_a_run() -> None:
    turned = ("radius", "--scenario", "single_axis_turned")
    assert "is turned at tick" in refusal(*turned)
    assert answer(*turned, "--set", "events=~", "--set", "start_time=3")["at"] > 3.0


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("components.finger_a1.parameters.physical_damping=1", "has no parameter physical_damping"),
        ("components.vr_a.parameters.local_normal_stifness=9", "Did you mean local_normal_stiff"),
        ("components.vr_a.parameters.box_is_pushed_with=given", "box_is_pushed_with is "),
        ("components.operator_a1.parameters.force_mode=[steps, none]", "Did you mean step"),
    ],
)
def test_a_parameter_that_no_model_has_is_refused_though_nothing_runs(
    written: str, said: str
) -> None:
    loop = ("passivity", "--scenario", "two_users_box", "--device-damping", "3", "--set", written)
    assert said in refusal(*loop)


def test_users_that_hear_each_other_after_different_delays_are_no_loop() -> None:
    longer = ("channels.lan_ab.round_trip_delay=~", "channels.lan_ab.each_way_delay=3")
    sets = [part for text in longer for part in ("--set", text)]
    loop = ("passivity", "--scenario", "thesis/three_users", "--device-damping", "3")
    answer(*loop)
    assert "after different delays" in refusal(*loop, *sets)


def test_a_design_stands_what_is_held_back_as_it_stands_losses() -> None:
    def designed(*sets: str) -> dict[str, Any]:
        return answer("design", *DISTRIBUTED, *(part for text in sets for part in ("--set", text)))

    plain, lost, late = (
        designed(*sets) for sets in ((), ("channels.lan.loss=0.3",), ("channels.lan.reorder=0.3",))
    )
    assert late == lost != plain
