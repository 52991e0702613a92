"""libcosim's fixed-step algorithm, given an OspSystemStructure.xml; its time is in whole ns."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from xml.sax.saxutils import quoteattr

import fmpy
from given import System, serve
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver


def structure(system: System) -> str:
    parts = "".join(
        f'<Simulator name="{part["name"]}" source={quoteattr("file://" + part["path"])} '
        f'stepSize="{part["every"] * system.step!r}"/>'
        for part in system.parts
    )
    joins = "".join(
        f'<VariableConnection><Variable simulator="{a}" name={quoteattr(x)}/>'
        f'<Variable simulator="{b}" name={quoteattr(y)}/></VariableConnection>'
        for a, x, b, y, _ in system.joins
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?><OspSystemStructure version="0.1" '
        'xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure">'
        f"<StartTime>0.0</StartTime><BaseStepSize>{system.step!r}</BaseStepSize>"
        "<Algorithm>fixedStep</Algorithm>"
        f"<Simulators>{parts}</Simulators><Connections>{joins}</Connections>"
        "</OspSystemStructure>"
    )


def run(system: System, record: Path | None) -> tuple[float, list[float]]:
    references = {
        path: {v.name: v.valueReference for v in fmpy.read_model_description(path).modelVariables}
        for path in {part["path"] for part in system.parts}
    }
    path_of = {part["name"]: part["path"] for part in system.parts}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "OspSystemStructure.xml").write_text(structure(system))
        execution = CosimExecution.from_osp_config_file(folder)
    give = {
        "Real": execution.real_initial_value,
        "Integer": execution.integer_initial_value,
        "Boolean": execution.boolean_initial_value,
    }
    index = {
        part["name"]: execution.slave_index_from_instance_name(part["name"])
        for part in system.parts
    }
    for part in system.parts:
        for name, (kind, value) in part["start"].items():
            give[kind](index[part["name"]], references[part["path"]][name], value)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    if record:
        # The binding cannot choose: every variable is written, as text.
        record.mkdir()
        execution.add_observer(CosimObserver.create_to_dir(str(record)))
    # Its last values are those behind its last step: ours are read before it.
    began = time.process_time()
    execution.step(system.ticks - 1)
    seconds = (time.process_time() - began) * system.ticks / (system.ticks - 1)
    values = []
    for part, variable, kind in system.watched:
        reference = references[path_of[part]][variable]
        last = observer.last_real_values if kind == "Real" else observer.last_integer_values
        values.append(last(index[part], [reference])[0])
    return seconds, values


if __name__ == "__main__":
    serve(run)
