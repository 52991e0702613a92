"""What is wrong with a Python component is a sentence with the line of its author's file."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import CohapticError, InputError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from tests.support.master.master_support import scenario_of

HEAD = """\
from cosim.base.component import Causality, Component, Variable, VariableType
OUT = Causality.OUTPUT
class Base(Component):
    def initialise(self, setup, inputs, outputs): self.value = outputs.get("value")
class Model(Base):
"""
VARIABLES = """\
    @property
    def variables(self):
        return [Variable(name="value", causality=OUT)]
"""
# The class's body, and what is said of it; the module is called as the test's folder asks.
BROKEN = {
    "a syntax error": (
        "    def variables(self:\n",
        "the module MODULE cannot be imported: SyntaxError: '(' was never closed (MODULE.py:6:18)",
    ),
    "an error in the module": (
        VARIABLES + "1 / 0\n",
        (
            "the module MODULE cannot be imported: ZeroDivisionError: division by zero "
            "(MODULE.py:9,"
            " in <module>)"
        ),
    ),
    "a module that ends the process": (
        VARIABLES + "raise SystemExit(3)\n",
        "the module MODULE cannot be imported: SystemExit: 3 (MODULE.py:9, in <module>)",
    ),
    "a module that is not there": (
        VARIABLES + "import nothing_of_that_name\n",
        (
            "the module MODULE cannot be imported: ModuleNotFoundError: No module named "
            "'nothing_of_that_name' (MODULE.py:9, in <module>)"
        ),
    ),
    "an error in __init__": (
        VARIABLES + "    def __init__(self):\n        self.gain = 1 / 0\n",
        (
            "MODULE:Model() cannot be made: ZeroDivisionError: division by zero (MODULE.py:10, in "
            "__init__)"
        ),
    ),
    "an argument too many": (
        VARIABLES + "    def __init__(self, gain):\n        pass\n",
        (
            "MODULE:Model() cannot be made: TypeError: Model.__init__() missing 1 "
            "required positional "
            "argument: 'gain'"
        ),
    ),
    "variables that fail": (
        "    @property\n    def variables(self):\n        return [Variable(nam='x')]\n",
        (
            "model cannot tell its variables: TypeError: Variable.__init__() got an "
            "unexpected keyword "
            "argument 'nam' (MODULE.py:8, in variables)"
        ),
    ),
    "no list": (
        "    @property\n    def variables(self):\n        return None\n",
        "Model.variables (MODULE.py:6) has to be a list of Variable, not nothing",
    ),
    "a generator": (
        "    @property\n    def variables(self):\n        yield 1\n",
        "Model.variables (MODULE.py:6) has to be a list of Variable, not a generator",
    ),
    "no property": (
        "    variables = 'value'\n",
        "Model.variables has to be a list of Variable, not the text 'value'",
    ),
    "a text among them": (
        "    @property\n    def variables(self):\n        return ['value']\n",
        "Model.variables (MODULE.py:6) has the text 'value' in it, which is no Variable",
    ),
    "two of one name": (
        (
            "    @property\n    def variables(self):\n"
            "        return [Variable(name='x', causality=OUT)] * 2\n"
        ),
        "Model.variables (MODULE.py:6) has two variables named 'x'",
    ),
    "no name": (
        (
            "    @property\n    def variables(self):\n"
            "        return [Variable(name=None, causality=OUT)]\n"
        ),
        "Model.variables (MODULE.py:6) has a variable whose name is nothing",
    ),
    "a causality in words": (
        (
            "    @property\n    def variables(self):\n"
            "        return [Variable(name='x', causality='output')]\n"
        ),
        (
            "Model.variables (MODULE.py:6): the causality of 'x' is the text 'output'; it "
            "has to be a "
            "Causality, such as Causality.PARAMETER. Did you mean OUTPUT?"
        ),
    ),
    "a type of Python": (
        (
            "    @property\n    def variables(self):\n"
            "        return [Variable(name='x', causality=OUT, type=float)]\n"
        ),
        (
            "Model.variables (MODULE.py:6): the type of 'x' is the class float; it has to be a "
            "VariableType, such as VariableType.FLOAT64."
        ),
    ),
    "a shape that is a number": (
        (
            "    @property\n    def variables(self):\n"
            "        return [Variable(name='x', causality=OUT, shape=3)]\n"
        ),
        (
            "Model.variables (MODULE.py:6): the shape of 'x' is 3; it has to be (), (n,) or (n, m) "
            "with whole numbers above 0"
        ),
    ),
    "a start of another shape": (
        (
            "    @property\n    def variables(self):\n"
            "        return [Variable(name='x', causality=OUT, shape=(2,), start=(1, 2, 3))]\n"
        ),
        "Model.variables (MODULE.py:6): the start of 'x' has the shape [3], the variable [2]",
    ),
    "an error while it is initialised": (
        VARIABLES + "    def initialise(self, setup, inputs, outputs):\n        {}['gain']\n",
        "model failed while it was initialised: KeyError: 'gain' (MODULE.py:10, in initialise)",
    ),
    "an error in a step, inside a library": (
        "    import json\n" + VARIABLES + "    def step(self, tick):\n"
        "        self.json.loads('{')\n",
        (
            "model failed in step at tick 0 (0 s): JSONDecodeError: Expecting property name "
            "enclosed in double quotes: line 1 column 2 (char 1) (MODULE.py:11, in step)"
        ),
    ),
    "a NaN": (
        VARIABLES + "    def evaluate(self, tick):\n"
        "        self.value[0] = float('nan') if tick == 5 else 1.0\n",
        "model.value became NaN in evaluate at tick 5 (0.00488281 s)",
    ),
    "a NaN in one element of several": (
        (
            "    @property\n    def variables(self):\n"
            "        return [Variable(name='value', causality=OUT),\n"
            "                Variable(name='y', causality=OUT, shape=(2,))]\n"
            "    def initialise(self, setup, inputs, outputs):\n        self.y = outputs['y']\n"
            "    def evaluate(self, tick):\n"
            "        self.y[:] = 1.0, float('nan') if tick == 5 else float('inf')\n"
        ),
        "model.y[2] became NaN in evaluate at tick 5 (0.00488281 s)",
    ),
}


@pytest.mark.parametrize("mistake", BROKEN)
def test_the_line_is_named(mistake: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    body, sentence = BROKEN[mistake]
    module = f"broken_{list(BROKEN).index(mistake)}"
    (tmp_path / f"{module}.py").write_text(HEAD + body, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    written = {
        "duration": 1,
        "components": {
            "model": {"python": f"{module}:Model", "rate": 1024},
            "reader": {"fmu": "hand", "rate": 1024},
        },
    }
    if "NaN" in mistake:
        written["connections"] = ["model.value -> reader.force"]
    with (
        pytest.raises(CohapticError) as caught,
        assemble(scenario_of(tmp_path, written)) as simulation,
    ):
        simulation.run(MemorySink())
    said = caught.value.message if isinstance(caught.value, InputError) else str(caught.value)
    assert said == sentence.replace("MODULE", module)
