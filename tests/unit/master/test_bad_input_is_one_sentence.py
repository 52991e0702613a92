"""What a user gets wrong is said in a sentence with its place, several at once, exit status 2."""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import fmus
import fmus.probe
from cosim.base.errors import InputError, InputErrors
from cosim.master.run.simulation import assemble
from tests.support.master.master_support import scenario_of


def hands(**more: Any) -> dict[str, Any]:
    """Two hands and a coupler at one rate, not connected."""
    component = {"rate": 1024, "station": "a"}
    return {
        "duration": 0.01,
        "components": {
            "hand": {"fmu": "hand", **component},
            "other": {"fmu": "hand", **component},
            "coupler": {"fmu": "virtual_coupler", **component},
            "vr": {"fmu": "distributed_workstation", **component},
            **more,
        },
    }


def refusal(folder: Path, written: Mapping[str, Any]) -> InputError:
    with pytest.raises(InputError) as caught:
        assemble(scenario_of(folder, written))
    assert caught.value.exit_status == 2
    return caught.value


CONNECTIONS = {
    "hand.positon -> coupler.position_a": "hand has no variable 'positon'. Did you mean position?",
    "hand.position -> coupler.velocity_a": "is in m and coupler.velocity_a in m/s",
    "hand.force -> coupler.position_a": "hand.force is an input, not an output, turn the arrow",
    "hand.position -> coupler.force": "coupler.force is an output, not an input",
    "hand.mass -> coupler.position_a": "'parameter'",
    "vr.finger_1.position -> coupler.position_a": "2 elements and coupler.position_a one element",
    "vr.finger_1 -> coupler.position_a": "joins a terminal to a variable",
    "vr.box_pose -> other.position": "joins a group to a variable",
    "vr.box_pose -> vr.box_velocity": "no output of vr.box_pose",
    "vr.finger_1.contact_state -> hand.force": "it is not a number",
    "hand.position -> vr.finger_1.status": "a real value does not fit an integer",
}


@pytest.mark.parametrize("connection", CONNECTIONS)
def test_a_connection_that_does_not_fit(tmp_path: Path, connection: str) -> None:
    error = refusal(tmp_path, {**hands(), "connections": [connection]})
    assert CONNECTIONS[connection] in str(error)
    assert "test.yaml:1:" in str(error)


def test_several_problems_at_once(tmp_path: Path) -> None:
    written = hands(third={"fmu": "hand", "rate": 1024, "parameters": {"mas": 1, "mass": "x"}})
    written["connections"] = ["hand.positon -> coupler.position_a", "hand.x -> coupler.position_b"]
    error = refusal(tmp_path, written)
    assert isinstance(error, InputErrors)
    assert len(error.errors) == 4


PARAMETERS: dict[str, tuple[Any, str]] = {
    "mas": (1.0, "no parameter 'mas'. Did you mean mass?"),
    "mass": (True, "is a number"),
    "force": (1.0, "under 'start'"),
    "initial_position": ([1.0, 2.0], "is a number"),
}


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_parameter_that_does_not_fit(tmp_path: Path, name: str) -> None:
    value, sentence = PARAMETERS[name]
    third = {"fmu": "hand", "rate": 1024, "parameters": {name: value}}
    assert sentence in str(refusal(tmp_path, hands(third=third)))


def test_a_value_below_its_minimum(tmp_path: Path) -> None:
    third = {"fmu": "hand", "rate": 1024, "parameters": {"mass": -1.0}}
    assert "the least that it can be is 0 kg" in str(refusal(tmp_path, hands(third=third)))


def test_a_value_that_the_model_refuses_says_what_the_model_said(tmp_path: Path) -> None:
    third = {"fmu": "hand", "rate": 1024, "parameters": {"mass": 0.0}}
    simulation = assemble(scenario_of(tmp_path, hands(third=third)))
    with pytest.raises(InputError, match="mass is 0 kg; give a mass above zero"):
        simulation.run()


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_parameters_that_do_not_go_together_are_found_at_the_start_and_placed(
    tmp_path: Path, flavour: str
) -> None:
    """Each is allowed by itself: only the model, leaving initialisation, knows better."""
    text = f"""\
    duration: 1
    rates: {{control: 1024}}
    components:
      good: {{fmu: hand, rate: control}}
      finger:
        fmu: pantograph
        flavour: {flavour}
        rate: control
        parameters:
          device: quanser
          initial_tip_position: [5, 5]
    """
    with pytest.raises(InputError) as caught:
        assemble(scenario_of(tmp_path, text)).run()
    said = str(caught.value)
    assert said.startswith(f"{tmp_path / 'test.yaml'}:")
    assert said.partition("test.yaml:")[2].startswith("12:"), said
    assert "finger returned status 'error' from reading its outputs at initialisation" in said
    assert "initial_tip_position (5, 5) m is out of reach" in said


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_a_refusal_that_names_no_parameter_is_placed_at_all_of_them(
    tmp_path: Path, flavour: str
) -> None:
    probe = fmus.probe.find("probe_failure", flavour)
    text = f"""\
    duration: 1
    components:
      bad: {{fmu: {probe}, rate: 1024, parameters: {{kind: initialise}}}}
    """
    simulation = assemble(scenario_of(tmp_path, text))
    with pytest.raises(
        InputError, match=r"test\.yaml:4:\d+: bad returned status 'error'"
    ) as caught:
        simulation.run()
    assert "This probe refuses to start, as it was told to." in str(caught.value)
    assert simulation.outcome.ticks == 0


def test_two_drivers_of_one_input(tmp_path: Path) -> None:
    written = hands()
    written["connections"] = [
        "hand.position -> coupler.position_a",
        "vr.box_pose.x -> coupler.position_a",
    ]
    assert "coupler.position_a" in str(refusal(tmp_path, written))


def test_an_array_and_its_element_are_one_input(tmp_path: Path) -> None:
    written = hands(
        body={"fmu": "object", "rate": 1024, "station": "a"},
        p={"fmu": "pantograph", "rate": 1024, "station": "a"},
    )
    written["connections"] = [
        "vr.finger_1.motor_torque -> p.motor_torque",
        "vr.finger_2.motor_torque[1] -> p.motor_torque[1]",
    ]
    assert "is driven twice" in str(refusal(tmp_path, written))


def test_an_algebraic_loop_is_spelled_out(tmp_path: Path) -> None:
    probe = {"fmu": str(fmus.probe.find("probe_tick")), "rate": 1024, "feedthrough": True}
    written = {
        "duration": 0.01,
        "components": {"a": probe, "b": probe},
        "connections": ["a.seen -> b.heard", "b.seen -> a.heard"],
    }
    error = refusal(tmp_path, written)
    assert "a.heard -> a.seen -> b.heard -> b.seen -> a.heard" in str(error)
    assert "delay of one tick on the connection 'b.seen -> a.heard'" in str(error)
    written["connections"][1] = {
        "from": "b.seen",
        "to": "a.heard",
        "delay": "1 ticks",
        "initial": "start",
    }
    assemble(scenario_of(tmp_path, written))


def test_no_loop_where_nothing_says_feedthrough(tmp_path: Path) -> None:
    probe = {"fmu": str(fmus.probe.find("probe_tick")), "rate": 1024}
    written = {
        "duration": 0.01,
        "components": {"a": probe, "b": probe},
        "connections": ["a.seen -> b.heard", "b.seen -> a.heard"],
    }
    simulation = assemble(scenario_of(tmp_path, written))
    assert simulation.assembly.lagging == ("a.seen -> b.heard", "b.seen -> a.heard")


def test_stations_are_joined_by_channels_only(tmp_path: Path) -> None:
    written = hands(far={"fmu": "hand", "rate": 1024, "station": "b"})
    written["connections"] = ["far.position -> coupler.position_a"]
    assert "channel" in str(refusal(tmp_path, written))


def test_nothing_to_record_under_that_name(tmp_path: Path) -> None:
    written = {**hands(), "record": ["hand.positon"]}
    assert "Did you mean position?" in str(refusal(tmp_path, written))
    assert "nothing" in str(refusal(tmp_path, {**hands(), "record": ["hand.z*"]}))


def broken(folder: Path, name: str, change: Any) -> dict[str, Any]:
    """A scenario with one FMU that ``change`` has spoiled."""
    path = folder / name
    with zipfile.ZipFile(fmus.find("hand")) as good:
        files = {entry: good.read(entry) for entry in good.namelist()}
    change(files)
    with zipfile.ZipFile(path, "w") as bad:
        for entry, data in files.items():
            bad.writestr(entry, data)
    return {"duration": 0.01, "components": {"hand": {"fmu": str(path), "rate": 1024}}}


def test_an_entry_outside_the_folder_is_refused(tmp_path: Path) -> None:
    for entry in ("../evil.txt", "/evil.txt", "a/../../evil.txt", "..\\evil.txt", "C:/evil.txt"):
        written = broken(tmp_path, "slip.fmu", lambda files, e=entry: files.update({e: b"x"}))
        assert "outside its folder" in str(refusal(tmp_path, written))
    assert not list(tmp_path.parent.glob("evil.txt"))


def test_a_damaged_archive(tmp_path: Path) -> None:
    path = tmp_path / "broken.fmu"
    written = {"duration": 0.01, "components": {"hand": {"fmu": str(path), "rate": 1024}}}
    path.write_bytes(b"this is no zip")
    assert "not a zip archive" in str(refusal(tmp_path, written))
    path.write_bytes(fmus.find("hand").read_bytes()[:5000])
    assert "damaged" in str(refusal(tmp_path, written))
    data = bytearray(fmus.find("hand").read_bytes())
    data[200:260] = bytes(60)
    path.write_bytes(data)
    assert "damaged" in str(refusal(tmp_path, written))


def test_no_library_for_this_machine(tmp_path: Path) -> None:
    def keep_another(files: dict[str, bytes]) -> None:
        for entry in [name for name in files if name.startswith("binaries/")]:
            data = files.pop(entry)
            files["binaries/riscv64-plan9/" + Path(entry).name] = data

    written = broken(tmp_path, "foreign.fmu", keep_another)
    error = str(refusal(tmp_path, written))
    assert "no library for" in error
    assert "riscv64-plan9" in error


def test_a_description_that_cannot_be_used(tmp_path: Path) -> None:
    written = broken(tmp_path, "none.fmu", lambda files: files.pop("modelDescription.xml"))
    assert "no modelDescription.xml" in str(refusal(tmp_path, written))

    def garble(files: dict[str, bytes]) -> None:
        files["modelDescription.xml"] = files["modelDescription.xml"][:300]

    assert "cannot be read" in str(refusal(tmp_path, broken(tmp_path, "half.fmu", garble)))

    def model_exchange(files: dict[str, bytes]) -> None:
        text = files["modelDescription.xml"].decode()
        begin, end = text.index("<CoSimulation"), text.index(">", text.index("<CoSimulation"))
        files["modelDescription.xml"] = (
            text[:begin] + '<ModelExchange modelIdentifier="hand"/' + text[end:].lstrip("/")
        ).encode()

    error = str(refusal(tmp_path, broken(tmp_path, "exchange.fmu", model_exchange)))
    assert "no co-simulation" in error


def test_a_fixed_step_that_does_not_divide_is_a_note(tmp_path: Path) -> None:
    path = tmp_path / "fixed.fmu"
    shutil.copy(fmus.probe.find("probe_fixed_step"), path)
    written = {"duration": 0.1, "components": {"fixed": {"fmu": str(path), "rate": 1000}}}
    with assemble(scenario_of(tmp_path, written)) as simulation:
        assert "was made for steps of 0.000976562 s" in simulation.notes[0]
        assert "a rate of 1024 Hz" in simulation.notes[0]
        assert simulation.run().ticks == 100
