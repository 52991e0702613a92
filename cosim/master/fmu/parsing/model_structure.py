"""What an FMU's outputs depend on, and its terminals."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from cosim.base.component import Variable


def among(
    variables: Mapping[str, Variable], dependencies: Mapping[str, tuple[str, ...]]
) -> dict[str, tuple[str, ...]]:
    """Those of the variables that are used, on such."""
    return {
        name: tuple(other for other in others if other in variables)
        for name, others in dependencies.items()
        if name in variables
    }


def direct_dependencies(description: Any) -> dict[str, tuple[str, ...]]:
    """Of every output; one that the model structure leaves out may depend on anything."""
    inputs = inputs_of(description)
    outputs = {v.name: inputs for v in description.modelVariables if v.causality == "output"}
    return outputs | dependencies_of(description.outputs, inputs)


def dependencies_of(unknowns: list[Any], inputs: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """Direct dependencies on inputs: all of them where the attribute is absent, none where empty.

    FMI 2.0 section 2.2.8, FMI 3.0 section 2.4.8.
    """
    return {
        unknown.variable.name: inputs
        if unknown.dependencies is None
        else tuple(v.name for v in unknown.dependencies if v.causality == "input")
        for unknown in unknowns
    }


def inputs_of(description: Any) -> tuple[str, ...]:
    """The names of the inputs."""
    return tuple(v.name for v in description.modelVariables if v.causality == "input")


def terminals_of(
    folder: Path, variables: Mapping[str, Variable], skipped: Collection[str]
) -> tuple[dict[str, dict[str, str]], tuple[str, ...]]:
    """FMI 3.0 section 2.4.9, and what is wrong with them; nested terminals get dotted names.

    Members that are ``skipped`` are variables, but have no values here.
    """
    path = folder / "terminalsAndIcons" / "terminalsAndIcons.xml"
    if not path.is_file():
        return {}, ()
    try:
        root = ET.parse(path).getroot()
    except (ET.ParseError, LookupError, ValueError) as error:
        return {}, (f"its terminals are left out: {path.name} cannot be read: {error}",)
    found: dict[str, dict[str, str]] = {}
    wrong: list[str] = []

    def visit(element: ET.Element, prefix: str) -> None:
        for terminal in element.findall("Terminal"):
            name = prefix + terminal.get("name", "")
            members: dict[str, str] = {}
            for member in terminal.findall("TerminalMemberVariable"):
                variable = member.get("variableName", "")
                if variable in variables:
                    members[member.get("memberName") or variable] = variable
                elif variable not in skipped:
                    wrong.append(f'the terminal "{name}" has a member "{variable}" that is nowhere')
            if name in found:
                wrong.append(f'two terminals are called "{name}"; the last one counts')
            if members:
                found[name] = members
            visit(terminal, f"{name}.")

    terminals = root.find("Terminals")
    if terminals is not None:
        visit(terminals, "")
    return found, tuple(wrong)
