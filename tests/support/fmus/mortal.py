"""An FMU that fails where and how its environment says, and a scenario that makes every call of it.

``native/mortal.h`` says what the environment holds. One archive of each version serves all: it is
compiled once.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from cosim.base.component import Causality, Cells, Component, Setup, Variable, VariableType
from cosim.base.texts import TextCells
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.scratch import scratch_folder

RATE, TICKS = 100, 8
SNIPPET = (Path(__file__).parent / "native" / "mortal.h").read_text()
TYPES = {
    2: ("Int32", "Boolean", "String"),
    3: (
        *("Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"),
        *("Boolean", "String", "Binary"),
    ),
}
"""Of variables beside ``u`` and ``y``, which are Float64: as inputs, and as outputs."""
START = {"Boolean": "false", "String": "x", "Binary": "00"}


class Gives(Component):
    """Puts out a value of every type and takes texts, so that they are read."""

    feedthrough = False

    @property
    def variables(self) -> Sequence[Variable]:
        """An output of each type, named after it, and two inputs."""
        made = [
            Variable(
                name=kind,
                type=VariableType(kind),
                causality=Causality.OUTPUT,
                variability="continuous" if kind == "Float64" else "discrete",
            )
            for kind in ("Float64", *TYPES[3])
            if kind != "Float32"
        ]
        heard = [
            Variable(
                name=f"heard_{kind}",
                type=VariableType(kind),
                causality=Causality.INPUT,
                variability="discrete",
            )
            for kind in ("String", "Binary")
        ]
        return [*made, *heard]

    def bind_texts(self, inputs: Mapping[str, TextCells], outputs: Mapping[str, TextCells]) -> None:
        """Keep the outputs."""
        self.texts = outputs

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Keep the outputs."""
        self.outputs = outputs

    def evaluate(self, tick: int) -> None:
        """Say the tick."""
        for cells in self.outputs.values():
            cells[:] = np.asarray(tick % 2, dtype=cells.dtype)
        self.texts["String"][0] = str(tick)
        self.texts["Binary"][0] = str(tick).encode()

    def save(self) -> None:
        """Nothing: all follows from the tick."""

    def load(self, values: None) -> None:
        """Nothing to load."""


@functools.cache
def mortal_fmu(version: int) -> Path:
    """The archive."""
    variables = [
        scalar(version, "u", 1, causality="input", start="0"),
        scalar(version, "y", 2, causality="output"),
        _text(version, "p", 3, "String", causality="parameter", variability="fixed"),
        scalar(version, "k", 4, "Int32", causality="parameter", variability="tunable", start="1"),
    ]
    outputs = [2]
    if version == 3:
        variables += [
            scalar(3, "n", 5, "UInt64", causality="structuralParameter", variability="fixed",
                   start="1"),
            _clock("asked", 10, "input", "fixed"),
            _clock("told", 11, "output", "triggered"),
            _clock("chosen", 12, "input", "fixed", 'intervalDecimal="0.01"'),
        ]  # fmt: skip
        outputs.append(11)
    for place, kind in enumerate(TYPES[version]):
        reference = 20 + 2 * place
        write = _text if kind in {"String", "Binary"} else scalar
        start = {} if write is _text else {"start": START.get(kind, "0")}
        variables.append(write(version, f"u_{kind}", reference, kind, causality="input", **start))
        variables.append(scalar(version, f"y_{kind}", reference + 1, kind, causality="output"))
        outputs.append(reference + 1)
    rows = [f'<Output valueReference="{each}" dependencies=""/>' for each in outputs]
    if version == 2:
        names = [text.split('valueReference="')[1].split('"')[0] for text in variables]
        places = [names.index(str(each)) + 1 for each in outputs]
        rows = [f'<Unknown index="{each}" dependencies=""/>' for each in places]
        rows = ["<Outputs>", *rows, "</Outputs>"]
    capital = "State" if version == 3 else "state"
    interface = {
        f"canGetAndSetFMU{capital}": "true",
        f"canSerializeFMU{capital}": "true",
        **({"hasEventMode": "true"} if version == 3 else {}),
    }
    category = '<Category name="logStatusError"/>'
    folder = scratch_folder("test")
    return foreign_fmu(
        folder,
        version,
        "\n".join(variables),
        snippet=SNIPPET,
        structure="".join(rows),
        interface=interface,
        before=f"<LogCategories>{category}</LogCategories>",
        name=f"mortal{version}",
    )


def _clock(name: str, reference: int, causality: str, variability: str, more: str = "") -> str:
    return (
        f'<Clock name="{name}" valueReference="{reference}" causality="{causality}" '
        f'intervalVariability="{variability}" {more}/>'
    )


def _text(version: int, name: str, reference: int, kind: str, **more: str) -> str:
    """A variable that holds a text, with something to start from."""
    start = START[kind]
    if version == 2:
        return scalar(2, name, reference, kind, start=start, **more)
    return scalar(3, name, reference, kind, f'<Start value="{start}"/>', **more)


def scenario(version: int, *, is_bare: bool, is_isolated: bool) -> str:
    """``box`` is the FMU; all of its types are connected, without event mode.

    One that ``is_bare`` has event mode, where there is one, an input of type Float64, and a
    parameter that is turned.
    """
    kinds = () if is_bare else TYPES[version]
    carried = [kind for kind in kinds if kind != "Float32"]
    record = ["box.y", *(f"box.y_{kind}" for kind in kinds if kind not in {"String", "Binary"})]
    connections = ["by.Float64 -> box.u", *(f"by.{kind} -> box.u_{kind}" for kind in carried)]
    if "Float32" in kinds:
        connections.append("by.Float64 -> box.u_Float32")
    texts = [kind for kind in ("String", "Binary") if kind in kinds]
    connections += [f"box.y_{kind} -> by.heard_{kind}" for kind in texts]
    keys = ", isolate: process" if is_isolated else ""
    if version == 3:
        keys += f", event_mode: {str(is_bare).lower()}"
    n = ", n: 2" if version == 3 else ""
    turned = "{at: 0.03, set: {box.k: 2}}" if is_bare else ""
    return (
        f"cohaptic: 1\nduration: {TICKS / RATE}\nbase_rate: {RATE}\ncomponents:\n"
        f"  by: {{python: '{__name__}:Gives', rate: {RATE}}}\n"
        f"  box: {{fmu: {mortal_fmu(version)}, rate: {RATE}, feedthrough: true, "
        f"parameters: {{p: text{n}}}{keys}}}\n"
        f"connections: [{', '.join(connections)}]\n"
        f"events: [{turned}]\n"
        f"record: [{', '.join(record)}]\n"
    )
