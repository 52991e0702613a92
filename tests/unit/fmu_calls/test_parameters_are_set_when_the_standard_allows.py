"""Tunable parameters are set between two steps, only when they change; structural ones before.

FMI 2.0.4 sections 2.2.7 and 4.2.4; FMI 3.0 sections 2.3.4 (configuration mode) and 2.4.7.4.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

COUNTS_SETS = """
/* whole[60]: 2 once it steps; whole[61]: inside a step or configuration mode. */
static int watch(Foreign *m, const char *call)
{
    if (is(call, "ExitInitializationMode"))
        m->whole[60] = 2;
    if (is(call, "EnterConfigurationMode"))
        m->whole[61] = 1;
    if (is(call, "ExitConfigurationMode"))
        m->whole[61] = 0;
    if (is(call, "SetUInt64") && !m->whole[61])
        return 3; /* the structural parameter outside of configuration mode */
    if ((is(call, "SetReal") || is(call, "SetFloat64")) && m->whole[61])
        return 3; /* another parameter inside */
    if ((is(call, "SetReal") || is(call, "SetFloat64")) && m->whole[60] == 2)
        m->real[5] += 1.0;
    return 0;
}
#define HOOK watch
"""


def fmu_of(folder: Path, version: int, *, structural: bool = False) -> Path:
    parameter = {"causality": "parameter", "variability": "tunable", "start": "1"}
    variables = [
        scalar(version, "p", 2, **parameter, min="0", max="10"),
        scalar(version, "sets", 5, causality="output"),
    ]
    if structural:
        size = {"causality": "structuralParameter", "variability": "fixed", "start": "1"}
        variables.append(scalar(3, "n", 6, "UInt64", **size))
    output = {
        2: '<Outputs><Unknown index="2" dependencies=""/></Outputs>',
        3: '<Output valueReference="5" dependencies=""/>',
    }[version]
    text = "\n".join(variables)
    return foreign_fmu(folder, version, text, structure=output, snippet=COUNTS_SETS)


def scenario(folder: Path, fmu: Path, events: list[Any], **more: Any) -> Any:
    component = {"fmu": str(fmu), "rate": 8, **more}
    return scenario_of(folder, {"duration": 1.25, "components": {"f": component}, "events": events})


def at(tick: int, value: float, name: str = "p") -> dict[str, Any]:
    return {"at": f"{tick} ticks", "set": {f"f.{name}": value}}


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("isolate", [{}, {"isolate": "process"}])
def test_it_is_set_once_for_each_change(
    tmp_path: Path, version: int, isolate: dict[str, str]
) -> None:
    fmu = fmu_of(tmp_path, version)
    events = [at(3, 7.0), at(5, 7.0), at(6, 9.0)]
    sink, _ = run(scenario(tmp_path, fmu, events, **isolate))
    # Outputs of a foreign FMU are read before it is set: it answers at its next step.
    assert sink.signal("f.sets").tolist() == [0, 0, 0, 0, 1, 1, 1, 2, 2, 2]
    assert sink.signal("f.p").tolist() == [1, 1, 1, 7, 7, 7, 9, 9, 9, 9]


@pytest.mark.parametrize("version", [2, 3])
def test_its_limits_hold(tmp_path: Path, version: int) -> None:
    fmu = fmu_of(tmp_path, version)
    with pytest.raises(InputError, match=r"f.p is 11; the most that it can be is 10"):
        assemble(scenario(tmp_path, fmu, [at(3, 11.0)]))


def test_a_structural_parameter_is_set_in_configuration_mode_alone(tmp_path: Path) -> None:
    fmu = fmu_of(tmp_path, 3, structural=True)
    parameters = {"parameters": {"n": 3, "p": 2.0}}
    sink, _ = run(scenario(tmp_path, fmu, [at(3, 7.0)], **parameters))
    assert sink.signal("f.sets").tolist()[-1] == 1
    with pytest.raises(
        InputError, match=r"f.n is of causality 'structuralParameter'; only a tunab"
    ):
        assemble(scenario(tmp_path, fmu, [at(3, 2, "n")]))
