"""A device component has the name, type, size and unit of every variable of the pantograph FMU."""

from __future__ import annotations

import math
import subprocess
import sys
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest

import fmus
from cosim.base.component import Role, Setup
from hil.device.component import DeviceComponent
from hil.device.contract import Status
from hil.device.errors import DeviceFault
from hil.device.pantograph import variables
from hil.drivers.mock.driver import MockDriver


def component(**options):
    return DeviceComponent(MockDriver, "mock://", options)


def bind(made, **parameters):
    views = {
        v.name: np.zeros(v.shape or (1,), np.float64 if v.type.is_float else np.int64)
        for v in made.variables
    }
    inputs = {v.name: views[v.name] for v in made.variables if v.causality == "input"}
    outputs = {v.name: views[v.name] for v in made.variables if v.causality == "output"}
    made.initialise(
        Setup(name="finger", parameters=parameters, tick=(1, 1024), period=1, seed=0),
        inputs,
        outputs,
    )
    return inputs, outputs


def test_the_variables_are_those_of_the_model_description():
    if not fmus.is_checkout():
        pytest.skip("the FMU is not built yet")
    with zipfile.ZipFile(fmus.find("pantograph", flavour="fmi3-arrays")) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    described = {
        element.get("name"): element
        for element in root.find("ModelVariables")
        if element.get("causality") != "independent"
    }
    ours = {variable.name: variable for variable in component().variables}
    assert set(ours) == set(described)
    for name, variable in ours.items():
        element = described[name]
        assert element.tag == variable.type.value, name
        assert element.get("causality", "local") == variable.causality.value, name
        assert element.get("unit") == variable.unit or variable.unit == "1", name
        size = tuple(int(d.get("start")) for d in element.findall("Dimension"))
        assert size == variable.shape, name


def test_every_signal_has_a_role():
    for variable in variables():
        if variable.causality in {"input", "output"}:
            assert variable.role is not None, variable.name


def test_a_mock_in_a_loop_measures_and_is_dry_unless_permitted():
    made = component()
    inputs, outputs = bind(made)
    for tick in range(200):
        made.read(tick)
        inputs["motor_torque"][:] = (0.001, 0.0)
        made.write(tick)
    assert outputs["status"][0] == Status.HOMED | Status.ACTIVE
    assert (outputs["applied_torque"] == 0.0).all()
    assert np.isfinite(outputs["joint_angle"]).all()
    for variable in variables():
        if variable.causality == "output" and variable.role is Role.SIMULATION_ONLY:
            expected = math.nan if variable.type.is_float else 0
            assert np.array_equal(
                outputs[variable.name],
                np.full_like(outputs[variable.name], expected),
                equal_nan=variable.type.is_float,
            )
    made.close()


def test_a_fault_ends_the_run_with_its_sentence():
    made = component()
    inputs, outputs = bind(made)
    made.read(0)
    inputs["motor_torque"][:] = (math.nan, 0.0)
    made.write(0)
    assert outputs["status"][0] & Status.FAULT
    assert not outputs["applied_torque"].any()
    made.read(1)
    with pytest.raises(DeviceFault, match=r"not a number.*zero torque confirmed"):
        made.write(1)
    made.close()


def test_hil_loads_nothing_of_cosim_but_protocol_and_errors():
    code = (
        "import sys, hil.device.component, hil.setup.registry, hil.setup.session\n"
        "import hil.drivers.mock.driver\n"
        "print([m for m in sys.modules if m.startswith('cosim.')])"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout
    assert all(module.split(".")[1] == "base" for module in eval(loaded))
