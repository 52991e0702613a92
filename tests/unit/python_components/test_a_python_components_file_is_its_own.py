"""A Python component comes from the file beside its scenario, also for a resolved scenario."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from cosim.scenario import load
from cosim.scenario.resolved import to_yaml

PART = """\
from cohaptic import Causality, Component, Variable


class Constant(Component):
    @property
    def variables(self):
        return [Variable(name="value", causality=Causality.OUTPUT, unit="1")]

    def initialise(self, setup, inputs, outputs):
        outputs["value"][0] = {value}
"""
SCENARIO = """\
cohaptic: 1
duration: 2 ms
rates: {control: 1000}
components: {c: {python: "PYTHON"}}
"""


def written(folder: Path, value: float, python: str = "constant_part:Constant") -> Path:
    folder.mkdir()
    (folder / "constant_part.py").write_text(PART.format(value=value), encoding="utf-8")
    file = folder / "s.yaml"
    file.write_text(SCENARIO.replace("PYTHON", python), encoding="utf-8")
    return file


def value_of(file: Path) -> float:
    sink = MemorySink()
    with assemble(load(file)) as simulation:
        simulation.run(sink)
    return float(sink.signal("c.value")[0])


def test_a_module_of_the_same_name_in_another_folder_is_another(tmp_path: Path) -> None:
    one, two = written(tmp_path / "one", 1.0), written(tmp_path / "two", 2.0)
    assert [value_of(one), value_of(two), value_of(one)] == [1.0, 2.0, 1.0]


def test_a_resolved_scenario_runs_from_another_folder(tmp_path: Path) -> None:
    file = written(tmp_path / "one", 3.0)
    with assemble(load(file)) as simulation:
        text = to_yaml(simulation.scenario)
    (tmp_path / "elsewhere").mkdir()
    resolved = tmp_path / "elsewhere" / "resolved.yaml"
    resolved.write_text(text, encoding="utf-8")
    assert value_of(resolved) == 3.0


def test_a_file_may_be_named(tmp_path: Path) -> None:
    assert value_of(written(tmp_path / "one", 4.0, "./constant_part.py:Constant")) == 4.0
    with pytest.raises(InputError, match=r"s\.yaml:4:26: .*there is no file .*nothing\.py"):
        load(written(tmp_path / "two", 4.0, "nothing.py:Constant"))


@pytest.mark.parametrize(
    ("method", "sentence"),
    [
        (
            'dependencies(self): return {"valeu": []}',
            "valeu', which is no output. Did you mean value",
        ),
        ('dependencies(self): return {"value": ["x"]}', "'x', which is no input"),
        ('terminals(self): return {"t": {"m": "valu"}}', "terminal t names 'valu'.*mean value"),
    ],
)
def test_what_dependencies_and_terminals_name_is_there(
    tmp_path: Path, method: str, sentence: str
) -> None:
    file = written(tmp_path / "one", 1.0)
    part = tmp_path / "one" / "constant_part.py"
    part.write_text(f"{part.read_text()}\n    @property\n    def {method}\n")
    with pytest.raises(InputError, match=sentence):
        assemble(load(file))
