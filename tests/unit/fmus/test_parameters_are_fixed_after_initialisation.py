"""Every parameter can be set before the simulation, and only a tunable one afterwards."""

from __future__ import annotations

import pytest

from tests.support.fmus import fmu_support as support

FLAVOURS = ("fmi2", "fmi3", "fmi3-arrays")


@pytest.mark.parametrize("flavour", FLAVOURS)
@pytest.mark.parametrize("name", [*support.MODELS, *support.PROBES])
def test_settable_before_and_refused_after(name: str, flavour: str) -> None:
    with support.Fmu(name, flavour) as fmu:
        parameters = fmu.names("parameter")
        starts = {parameter: fmu.get(parameter) for parameter in parameters}
        for parameter, value in starts.items():
            fmu.set(parameter, value)
        fmu.enter()
        for parameter, value in starts.items():
            fmu.set(parameter, value)
        fmu.call("ExitInitializationMode")
        for parameter, value in starts.items():
            if fmu.variables[parameter].variability == "tunable":
                fmu.set(parameter, value)
                continue
            before = len(fmu.log)
            with pytest.raises(support.Refused):
                fmu.set(parameter, value)
            assert parameter.split("[")[0] in fmu.log[before][2]
            assert "before the simulation starts" in fmu.log[before][2]
        fmu.step(support.step_of(name))  # a refused call does no harm


@pytest.mark.parametrize("name", [*support.MODELS, *support.PROBES])
def test_outputs_can_never_be_set(name: str) -> None:
    with support.Fmu(name) as fmu:
        fmu.start()
        for output in fmu.names("output", "local", "calculatedParameter"):
            with pytest.raises(support.Refused):
                fmu.set(output, fmu.get(output))
            assert "computed by the model" in fmu.log[-1][2]
