"""What ``cohaptic fmu inspect`` says about an FMU."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

from cosim.base.component import Variable
from cosim.master.components.interface import is_tunable
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.reading import read_description

_CAPABILITIES = (
    "canHandleVariableCommunicationStepSize",
    "canGetAndSetFMUstate",
    "canGetAndSetFMUState",
    "canSerializeFMUstate",
    "canSerializeFMUState",
    "providesDirectionalDerivative",
    "providesDirectionalDerivatives",
    "hasEventMode",
)


def describe(path: Path) -> dict[str, Any]:
    """The FMU as plain data.

    Raises:
        InputError: it is not an FMU that can be read.
    """
    description = read_description(path)
    fmpy: Any = importlib.import_module("fmpy.model_description")
    model = fmpy.read_model_description(str(description.folder), validate=False)
    interface = model.coSimulation
    binaries = description.folder / "binaries"
    platforms = [at.name for at in binaries.iterdir()] if binaries.is_dir() else []
    return {
        "file": str(path),
        "sha256": description.sha256,
        "fmi": model.fmiVersion,
        "model": model.modelName,
        "description": model.description,
        "tool": model.generationTool,
        "token": description.token,
        "platforms": sorted(platforms),
        "capabilities": [
            name for name in _CAPABILITIES if getattr(interface, name, None) in {True, "true"}
        ],
        "step_size": model.defaultExperiment.stepSize if model.defaultExperiment else None,
        "variables": [_variable(each, description) for each in description.variables.values()],
        "clocks": [_clock(each, description) for each in description.clocks],
        "terminals": {name: dict(members) for name, members in description.terminals.items()},
    }


def _variable(variable: Variable, description: FmuDescription) -> dict[str, Any]:
    return {
        "name": variable.name,
        "type": variable.type.value,
        "causality": variable.causality.value,
        "tunable": is_tunable(variable),
        "unit": variable.unit,
        "shape": list(variable.shape),
        "start": variable.start,
        "minimum": variable.minimum,
        "maximum": variable.maximum,
        "items": dict(variable.items) if variable.items else None,
        "depends_on": list(description.dependencies.get(variable.name, ())),
        "description": variable.description,
    }


def _clock(written: dict[str, Any], description: FmuDescription) -> dict[str, Any]:
    """One as it is written, and the variables that belong to it."""
    name = written["name"]
    about = {key: value for key, value in written.items() if value is not None}
    members = [each for each, of in description.clocked.items() if name in of]
    return about | {"of": list(written["of"]), "variables": members}


def to_text(report: dict[str, Any]) -> str:
    """The same for reading: a head, then the variables by causality."""
    head = {
        "model": f"{report['model']}: {report['description'] or 'no description'}",
        "file": report["file"],
        "FMI": report["fmi"],
        "made by": report["tool"] or "not said",
        "platforms": ", ".join(report["platforms"]) or "none",
        "can": ", ".join(report["capabilities"]) or "nothing optional",
        "step": f"{report['step_size']} s" if report["step_size"] else "not said",
    }
    lines = [f"{name + ':':<11}{text}" for name, text in head.items()]
    variables: list[dict[str, Any]] = report["variables"]
    for causality in dict.fromkeys(variable["causality"] for variable in variables):
        lines += ["", f"{causality}:"]
        chosen = [variable for variable in variables if variable["causality"] == causality]
        width = max(len(_label(variable)) for variable in chosen)
        lines += [f"  {_label(each):<{width}}  {_facts(each)}" for each in chosen]
    if report["clocks"]:
        lines += ["", "clocks:"]
        lines += [f"  {each['name']}  {_ticks(each)}" for each in report["clocks"]]
    if report["terminals"]:
        lines += ["", "terminals:"]
        lines += [f"  {name}: {', '.join(of)}" for name, of in report["terminals"].items()]
    return "\n".join(lines)


def _ticks(clock: dict[str, Any]) -> str:
    facts = [clock["variability"], clock["causality"]]
    for what in ("interval", "shift"):
        if f"{what}Counter" in clock and "resolution" in clock:
            facts.append(f"{what} {clock[f'{what}Counter']}/{clock['resolution']} s")
        elif f"{what}Decimal" in clock:
            facts.append(f"{what} {clock[f'{what}Decimal']} s")
    if clock["of"]:
        facts.append(f"belongs to {', '.join(clock['of'])}")
    if clock["variables"]:
        facts.append(f"has {', '.join(clock['variables'])}")
    return ", ".join(facts)


def _label(variable: dict[str, Any]) -> str:
    shape = ", ".join(str(size) for size in variable["shape"])
    return f"{variable['name']}[{shape}]" if shape else variable["name"]


def _facts(variable: dict[str, Any]) -> str:
    facts = [variable["type"]]
    if variable["unit"]:
        facts.append(variable["unit"])
    if variable["start"] is not None:
        facts.append(f"start {variable['start']}")
    if variable["tunable"]:
        facts.append("tunable")
    if variable["minimum"] is not None:
        facts.append(f"at least {variable['minimum']:g}")
    if variable["maximum"] is not None:
        facts.append(f"at most {variable['maximum']:g}")
    if variable["items"]:
        facts.append(" | ".join(f"{value} {name}" for name, value in variable["items"].items()))
    if variable["depends_on"]:
        facts.append(f"depends on {', '.join(variable['depends_on'])}")
    return f"{', '.join(facts)}. {variable['description']}"
