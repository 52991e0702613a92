"""FMUs that nobody here wrote run here as they do in FMPy, and as their authors say they do.

``git clone https://github.com/modelica/Reference-FMUs``, then
``COHAPTIC_REFERENCE_FMUS=Reference-FMUs uv run pytest -m peers``.
"""

from __future__ import annotations

import csv
import json
import os
import platform
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from cosim.scenario import load
from tests.support.peers.reference_fmus import build, model_names

SOURCES = Path(os.environ.get("COHAPTIC_REFERENCE_FMUS", "Reference-FMUs"))
pytestmark = [
    pytest.mark.peers,
    pytest.mark.skipif(
        sys.platform != "linux" or platform.machine() != "x86_64", reason="built for Linux x86-64"
    ),
    pytest.mark.skipif(
        not (SOURCES / "src").is_dir(), reason="COHAPTIC_REFERENCE_FMUS is no checkout of them"
    ),
]

# Rate (Hz) and duration (s), as their default experiments have them; Stair asks to end at 9 s.
EXPERIMENTS = {
    "BouncingBall": (100, 3),
    "Dahlquist": (10, 10),
    "Feedthrough": (10, 2),
    "Resource": (1, 1),
    "Roberts": (1000, 1),
    "Stair": (5, 8),
    "StateSpace": (1, 10),
    "VanDerPol": (100, 20),
}
CASES = [
    (model, version)
    for version in (2, 3)
    for model in EXPERIMENTS
    if (SOURCES / model / f"FMI{version}.xml").exists()
]
ONE_STEP = {"Roberts": 1e-7}
"""It adds up its own time in steps of 1 ms, so that whether a step is due hangs on the last bit of
the time it is given: FMPy's is a sum of steps, ours k T rounded once. Its step moves it so far."""
EXPECTED = ("BouncingBall", "Dahlquist", "Resource", "Stair", "VanDerPol")


@pytest.fixture(scope="module")
def archives(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, int], Path]:
    folder = tmp_path_factory.mktemp("reference")
    return {
        (model, version): build(SOURCES, model, version, folder)
        for version in (2, 3)
        for model in model_names(SOURCES, version)
    }


def run(folder: Path, duration: float, components: dict[str, Any], *connections: str) -> MemorySink:
    path = folder / "s.yaml"
    written = {"duration": duration, "components": components, "connections": list(connections)}
    path.write_text(json.dumps({"cohaptic": 1, **written}))
    sink = MemorySink()
    with assemble(load(path)) as simulation:
        simulation.run(sink)
    return sink


def elements(sink: MemorySink, name: str, shape: tuple[int, ...]) -> np.ndarray:
    """A signal, (ticks,) or (ticks, elements)."""
    if not shape:
        return np.asarray(sink.signal(name))
    columns = [sink.signal(f"{name}[{i + 1}]") for i in range(shape[0])]
    return np.stack([np.asarray(column) for column in columns], axis=1)


@pytest.mark.parametrize(("model", "version"), CASES)
def test_every_output_has_the_bits_that_fmpy_gives(
    model: str, version: int, archives: dict[tuple[str, int], Path], tmp_path: Path
) -> None:
    from fmpy import simulate_fmu

    rate, duration = EXPERIMENTS[model]
    path = archives[model, version]
    sink = run(tmp_path, duration, {"m": {"fmu": str(path), "rate": rate}})
    expected = simulate_fmu(
        str(path),
        fmi_type="CoSimulation",
        start_time=0.0,
        stop_time=duration,
        output_interval=1 / rate,
        step_size=1 / rate,
    )
    compared = 0
    for name in expected.dtype.names[1:]:
        column = expected[name]
        if column.dtype.kind not in "fiub":
            continue
        actual = elements(sink, f"m.{name}", column.shape[1:])
        assert len(actual) == duration * rate
        allowed = ONE_STEP.get(model, 0.0)
        stated = column[: len(actual)].astype(actual.dtype)
        np.testing.assert_allclose(actual, stated, rtol=0, atol=allowed, err_msg=name)
        compared += 1
    assert compared


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("model", EXPECTED)
def test_the_authors_own_results_are_met(
    model: str, version: int, archives: dict[tuple[str, int], Path], tmp_path: Path
) -> None:
    rate, duration = EXPERIMENTS[model]
    sink = run(tmp_path, duration, {"m": {"fmu": str(archives[model, version]), "rate": rate}})
    with (SOURCES / model / f"{model}_out.csv").open() as file:
        header, *rows = list(csv.reader(file))
    for column, name in enumerate(header[1:], start=1):
        actual = np.asarray(sink.signal(f"m.{name}"), float)
        stated = np.array([float(row[column]) for row in rows[: len(actual)]])
        np.testing.assert_allclose(actual, stated, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("versions", [(2, 2), (2, 3), (3, 2), (3, 3)])
def test_every_type_passes_from_one_to_the_next_in_the_same_tick(
    versions: tuple[int, int], archives: dict[tuple[str, int], Path], tmp_path: Path
) -> None:
    sent = {
        "Float64_continuous": 2.5,
        "Float64_discrete": -1.25,
        "Int32": -7,
        "Boolean": True,
        "Enumeration": 2,
    }
    if versions == (3, 3):
        sent |= {
            "Float32_continuous": 0.5,
            "Float32_discrete": 0.25,
            "Int8": -128,
            "UInt8": 255,
            "Int16": -(2**15),
            "UInt16": 2**16 - 1,
            "UInt32": 2**32 - 1,
            "Int64": -(2**62),
        }
    first, second = (str(archives["Feedthrough", version]) for version in versions)
    start = {f"{name}_input": value for name, value in sent.items()} | {"String_input": "hello"}
    components = {
        "a": {"fmu": first, "rate": 10, "feedthrough": True, "start": start},
        "b": {"fmu": second, "rate": 10, "feedthrough": True},
    }
    sink = run(tmp_path, 1, components, *(f"a.{n}_output -> b.{n}_input" for n in sent))
    for name, value in sent.items():
        assert (np.asarray(sink.signal(f"b.{name}_output")) == value).all(), name


def test_arrays_take_the_size_that_structural_parameters_give(
    archives: dict[tuple[str, int], Path], tmp_path: Path
) -> None:
    """x' = A x + B u, y = C x, by the FMU's own Euler steps of 1 ms."""
    matrices = {"A": [[0, 0.5], [-0.5, 0]], "B": [[1, 0], [0, 1]], "C": [[1, 0], [0, 2]]}
    component = {
        "fmu": str(archives["StateSpace", 3]),
        "rate": 1,
        "parameters": {"D": [0, 0, 0, 0], "m": 2, "n": 2, "r": 2, **matrices},
        "start": {"u": [1, 0]},
    }
    sink = run(tmp_path, 6, {"m": component})
    assert "m.y[3]" not in {column.name for group in sink.groups for column in group.columns}
    found = np.stack([sink.signal("m.y[1]"), sink.signal("m.y[2]")], axis=1)
    a, b, c = (np.array(matrices[name], float) for name in "ABC")
    x = np.zeros(2)
    for row in found:
        np.testing.assert_allclose(row, c @ x, atol=1e-12)
        for _ in range(1000):
            x = x + 1e-3 * (a @ x + b @ [1.0, 0.0])


def test_what_cannot_run_is_a_sentence(
    archives: dict[tuple[str, int], Path], tmp_path: Path
) -> None:
    clocks = {"m": {"fmu": str(archives["Clocks", 3]), "rate": 1}}
    with pytest.raises(InputError, match="offers no co-simulation"):
        run(tmp_path, 1, clocks)
    wide = {"m": {"fmu": str(archives["StateSpace", 3]), "rate": 1, "parameters": {"m": 9}}}
    with pytest.raises(InputError, match=r"s\.yaml:1:\d+: .*must not be greater than 5"):
        run(tmp_path, 1, wide)
    for version in (2, 3):
        stair = {"m": {"fmu": str(archives["Stair", version]), "rate": 5}}
        sink = run(tmp_path, 12, stair)  # it asks for the end, and that is a good one
        assert len(sink.rows(0)) == 45
