"""A snapshot is put back whole into the run that it was taken of; any other is a sentence."""

from __future__ import annotations

import re
import shutil
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fmus
from cosim.base.errors import InputError, RunError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import Simulation, assemble
from cosim.master.run.snapshot import Snapshot, read_snapshot
from cosim.record.playback import KINDS
from cosim.run import run_scenario
from tests.support.master.master_support import scenario_of

OWN = """
from tests.support.master.resumable_parts import Saved
class Own(Saved):
    gain = {value}
"""
PARTS = "tests.support.master.resumable_parts"
TICK, FIRST_END, END = 37, 60, 90

WRITTEN: dict[str, Any] = {
    "duration": FIRST_END / 1024,
    "seed": 3,
    "components": {
        "push": {
            "fmu": "signal",
            "rate": 1024,
            "station": "a",
            "parameters": {"mode": "sine", "frequency": 20.0},
        },
        "hand": {"fmu": "hand", "rate": 1024, "station": "b"},
    },
    "channels": {"lan": {"between": ["a", "b"], "rate": 128, "round_trip_delay": 1, "loss": 0.2}},
    "connections": ["push.value -> hand.force via lan"],
}


def with_part(name: str) -> dict[str, Any]:
    part = {"python": f"{PARTS}:{name}", "rate": 1024, "station": "a"}
    return {**WRITTEN, "components": {**WRITTEN["components"], "part": part}}


def simulation_of(folder: Path, written: Any = WRITTEN, sets: Sequence[str] = ()) -> Simulation:
    return assemble(scenario_of(folder, written, sets), kinds=KINDS)


def snapshot_of(folder: Path, written: Any = WRITTEN) -> Snapshot:
    with simulation_of(folder, written) as simulation:
        simulation.start()
        simulation.advance(TICK)
        return simulation.snapshot()


def cells_at_the_end(simulation: Simulation) -> Any:
    simulation.start(END)
    simulation.advance(END)
    return simulation.program.cells.copy()


def goes_on(folder: Path, written: Any) -> None:
    """In a new simulation, and again and again in a running one, as without interruption."""
    snapshot = Snapshot.from_bytes(snapshot_of(folder, written).to_bytes())
    with simulation_of(folder, written) as simulation:
        expected = cells_at_the_end(simulation)
    with simulation_of(folder, written) as simulation:
        simulation.restore(snapshot)
        np.testing.assert_array_equal(cells_at_the_end(simulation), expected)
        if not simulation.repeated:
            for _ in range(2):
                simulation.restore(snapshot)
                assert simulation.program.kernel.tick == TICK
                simulation.advance(END)
                np.testing.assert_array_equal(simulation.program.cells, expected)


def begin_from(simulation: Simulation, snapshot: Snapshot, sink: MemorySink | None = None) -> None:
    simulation.restore(snapshot)
    simulation.run(sink)


def refuses(simulation: Simulation, snapshot: Snapshot, sentence: str) -> None:
    with simulation, pytest.raises(InputError, match=sentence):
        begin_from(simulation, snapshot)


def test_everything_is_put_back(tmp_path: Path) -> None:
    goes_on(tmp_path, WRITTEN)


def test_after_fates_were_drawn_anew(tmp_path: Path) -> None:
    """The table of fates has moved on from the packets that it began with."""
    lan = {
        "between": ["a", "b"],
        "rate": 1024,
        "round_trip_delay": 6,
        "jitter": "4 ms",
        "loss": 0.3,
    }
    written = {**WRITTEN, "duration": 6.0, "channels": {"lan": lan}}
    ends = []
    with simulation_of(tmp_path, written) as simulation:
        simulation.start()
        simulation.advance(3000)
        snapshot = simulation.snapshot()
        simulation.advance(5500)
        ends.append(simulation.program.cells.copy())
    with simulation_of(tmp_path, written) as simulation:
        simulation.restore(snapshot)
        simulation.start()
        for tick in range(3000, 3100):
            simulation.advance(tick)
        simulation.advance(5500)
        ends.append(simulation.program.cells.copy())
    np.testing.assert_array_equal(*ends)
    assert snapshot.values["bundles"][0]["fate_first"] > 0


def test_a_python_component_offers_save_and_load(tmp_path: Path) -> None:
    goes_on(tmp_path, with_part("Saved"))


def test_what_follows_is_recorded_alone(tmp_path: Path) -> None:
    """Rows from the snapshot's tick on, which a sink that wants them all from 0 on notices."""
    snapshot = snapshot_of(tmp_path)
    with simulation_of(tmp_path) as simulation, pytest.raises(AssertionError, match="follow"):
        begin_from(simulation, snapshot, MemorySink())


@pytest.mark.parametrize(
    ("part", "sentence"),
    [
        ("Counting", r"part \(Counting\) has no save\(\) and load\(\): give it"),
        ("SavesArrays", r"part: save\(\) returned a value of type ndarray at \['steps'\]\[0\]"),
    ],
)
def test_a_component_that_cannot_be_saved(tmp_path: Path, part: str, sentence: str) -> None:
    with pytest.raises((InputError, RunError), match=sentence):
        snapshot_of(tmp_path, with_part(part))


def test_a_component_that_does_not_take_it_back(tmp_path: Path) -> None:
    written = with_part("FailsToLoad")
    snapshot = snapshot_of(tmp_path, written)
    with (
        simulation_of(tmp_path, written) as simulation,
        pytest.raises(RunError, match=r"part failed in load: .*this is not mine"),
    ):
        begin_from(simulation, snapshot)


def test_a_device_is_refused(tmp_path: Path) -> None:
    pantograph = {"device": "mock://", "rate": 1024}
    with pytest.raises(InputError, match="arm is a device"):
        snapshot_of(tmp_path, {"duration": 0.1, "components": {"arm": pantograph}})


@pytest.mark.parametrize(
    ("sets", "sentence"),
    [
        (("seed=4",), "another plan"),
        (("channels.lan.round_trip_delay=3",), "another plan"),
        (("channels.lan.loss=0.3",), "another plan"),
        (("components.hand.rate=512",), "another plan"),
        (("components.push.parameters.frequency=21.0",), "push had other parameters"),
        (("components.hand.flavour=fmi2",), "its FMU of hand has another content"),
        (("object",), "its FMU of hand has another content"),
        (("duration=0.01",), "the run ends at tick 1[01]; give it a longer duration"),
    ],
)
def test_of_another_run(tmp_path: Path, sets: tuple[str, ...], sentence: str) -> None:
    snapshot = snapshot_of(tmp_path)
    if sets == ("object",):
        written = {
            **WRITTEN,
            "components": {
                **WRITTEN["components"],
                "hand": {"fmu": "object", "rate": 1024, "station": "b"},
            },
            "connections": [],
        }
        refuses(simulation_of(tmp_path, written), snapshot, sentence)
    else:
        refuses(simulation_of(tmp_path, WRITTEN, sets), snapshot, sentence)


@pytest.mark.parametrize("kind", ["fmu's table", "csv", "record", "module"])
def test_of_files_with_another_content(kind: str, tmp_path: Path) -> None:
    """A table, a recording or a module that was written again, under the same name."""
    parts = {
        "fmu's table": {
            "fmu": "signal",
            "parameters": {"mode": "table", "table_file": str(tmp_path / "t.txt")},
        },
        "csv": {"table": str(tmp_path / "t.csv")},
        "record": {"playback": str(tmp_path / "run")},
        "module": {"python": f"{tmp_path / 'own_part.py'}:Own"},
    }
    part = {**parts[kind], "rate": 1024, "station": "a"}
    name = "push" if kind == "record" else "part"
    written = {**WRITTEN, "components": {**WRITTEN["components"], name: part}}
    write_files(kind, tmp_path, 1.5)
    snapshot = snapshot_of(tmp_path, written)
    goes_on(tmp_path, written)
    write_files(kind, tmp_path, 2.5)
    refuses(simulation_of(tmp_path, written), snapshot, f"{name} (reads had|had other)")


def write_files(kind: str, folder: Path, value: float) -> None:
    match kind:
        case "fmu's table":
            (folder / "t.txt").write_text(f"0 {value}\n1 {value}\n")
        case "csv":
            (folder / "t.csv").write_text(f"time [s],value\n0,{value}\n1,{value}\n")
        case "record":
            shutil.rmtree(folder / "run", ignore_errors=True)
            frequency = f"components.push.parameters.frequency={value}"
            (folder / "recorded").mkdir(exist_ok=True)
            run_scenario(
                scenario_of(folder / "recorded", WRITTEN, (frequency, "duration=0.125")),
                folder / "run",
                figure=False,
            )
        case _:
            (folder / "own_part.py").write_text(OWN.format(value=value))


def test_of_other_components(tmp_path: Path) -> None:
    snapshot = snapshot_of(tmp_path)
    refuses(simulation_of(tmp_path, with_part("Saved")), snapshot, "with the components hand, push")


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return snapshot_of(tmp_path_factory.mktemp("snapshot")).to_bytes()


@settings(deadline=None, max_examples=200)
@given(place=st.integers(0), bit=st.integers(0, 7))
def test_a_flipped_bit(content: bytes, place: int, bit: int) -> None:
    damaged = bytearray(content)
    damaged[place % len(damaged)] ^= 1 << bit
    with pytest.raises(InputError):
        Snapshot.from_bytes(bytes(damaged))


@settings(deadline=None, max_examples=100)
@given(length=st.integers(0))
def test_cut_off(content: bytes, length: int) -> None:
    with pytest.raises(InputError):
        Snapshot.from_bytes(content[: length % len(content)])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda content: content.replace(b"shot 1\n", b"shot 7\n", 1), "format 7; this version re"),
        (lambda content: content[:-1], "is damaged or cut off"),
        (lambda content: content + b"x", "is damaged or cut off"),
        (lambda _: b"PK\3\4", "is not a snapshot of a run"),
        (lambda _: b"", "is not a snapshot of a run"),
    ],
)
def test_a_file_says_what_is_wrong(
    content: bytes, change: Callable[[bytes], bytes], sentence: str, tmp_path: Path
) -> None:
    file = tmp_path / "snapshot"
    file.write_bytes(change(content))
    with pytest.raises(InputError, match=f"{re.escape(str(file))}.*{sentence}"):
        read_snapshot(file)


def test_there_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read: No such file"):
        read_snapshot(tmp_path / "snapshot")


def stateless(folder: Path) -> dict[str, Any]:
    """The same with a hand that does not give its state away."""
    target = folder / "hand.fmu"
    with zipfile.ZipFile(fmus.find("hand", "fmi3")) as source, zipfile.ZipFile(target, "w") as made:
        for name in source.namelist():
            content = source.read(name)
            if name == "modelDescription.xml":
                assert b'canSerializeFMUState="true"' in content
                content = content.replace(b'canSerializeFMUState="true"', b"")
            made.writestr(name, content)
    hand = {**WRITTEN["components"]["hand"], "fmu": str(target)}
    return {**WRITTEN, "components": {**WRITTEN["components"], "hand": hand}}


def test_without_state_the_run_is_repeated(tmp_path: Path) -> None:
    written = stateless(tmp_path)
    assert simulation_of(tmp_path, written).repeated == ("hand",)
    goes_on(tmp_path, written)


def test_what_is_repeated_must_be_the_same(tmp_path: Path) -> None:
    written = stateless(tmp_path)
    written["components"]["part"] = {"python": f"{PARTS}:Wandering", "rate": 1024, "station": "a"}
    snapshot = snapshot_of(tmp_path, written)
    with (
        simulation_of(tmp_path, written) as simulation,
        pytest.raises(RunError, match=f"other values at tick {TICK} than the snapshot"),
    ):
        begin_from(simulation, snapshot)


def test_a_repeated_run_is_restored_before_it_starts(tmp_path: Path) -> None:
    written = stateless(tmp_path)
    snapshot = snapshot_of(tmp_path, written)
    with simulation_of(tmp_path, written) as simulation:
        simulation.start()
        with pytest.raises(InputError, match=r"hand does not give its state away.*before the run"):
            simulation.restore(snapshot)


def test_nothing_runs(tmp_path: Path) -> None:
    with simulation_of(tmp_path) as simulation, pytest.raises(RunError, match="Nothing runs"):
        simulation.snapshot()
