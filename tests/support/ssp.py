"""System structures of SSP around one FMU whose output is the sum of its input and parameter."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

from cosim.ssp.package import read_system
from tests.support.fmus.foreign import foreign_fmu, scalar

HEAD = (
    '<SystemStructureDescription version="{version}" name="test" '
    'xmlns="http://ssp-standard.org/SSP1/SystemStructureDescription" '
    'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" '
    'xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
    'xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping">'
)
PASS = """
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "DoStep"))
            m->real[1] = m->real[2] + m->real[3];
        return 0;
    }
    #define HOOK hook
"""
"""y = u + p, a step late."""


def adder_folder(folder: Path) -> Path:
    """``folder``, with ``adder.fmu`` in it."""
    units = (
        '<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>'
        '<DefaultExperiment stepSize="0.125"/>'
    )
    foreign_fmu(
        folder,
        3,
        scalar(3, "y", 1, causality="output", unit="m")
        + scalar(3, "u", 2, causality="input", start="0", unit="m")
        + scalar(3, "p", 3, causality="parameter", variability="fixed", start="0", unit="m"),
        structure='<Output valueReference="1" dependencies=""/>',
        before=units,
        snippet=PASS,
        name="adder",
    )
    return folder


def connectors(**kinds: str) -> str:
    inner = "".join(
        f'<Connector name="{name}" kind="{kind}"><ssc:Real unit="m"/></Connector>'
        for name, kind in kinds.items()
    )
    return f"<Connectors>{inner}</Connectors>"


PORTS = connectors(y="output", u="input", p="parameter")


def component(name: str, inside: str = "") -> str:
    return f'<Component name="{name}" source="adder.fmu">{PORTS}{inside}</Component>'


def values(*given: str, mapping: str = "", prefix: str = "") -> str:
    parameters = "".join(
        f'<ssv:Parameter name="{name}"><ssv:Real value="{value}"{rest}/></ssv:Parameter>'
        for name, value, rest in (text.split("|") for text in given)
    )
    return (
        f'<ParameterBinding prefix="{prefix}"><ParameterValues><ssv:ParameterSet version="1.0" '
        f'name="s"><ssv:Parameters>{parameters}</ssv:Parameters><ssv:Units><ssc:Unit name="inch">'
        '<ssc:BaseUnit m="1" factor="0.0254"/></ssc:Unit></ssv:Units></ssv:ParameterSet>'
        f"</ParameterValues>{mapping}</ParameterBinding>"
    )


def bindings(*each: str) -> str:
    return f"<ParameterBindings>{''.join(each)}</ParameterBindings>"


def ssd(folder: Path, inside: str, version: str = "1.0", start: str = "0") -> Path:
    file = folder / "SystemStructure.ssd"
    experiment = f'<DefaultExperiment startTime="{start}" stopTime="1"/>'
    file.write_text(
        HEAD.format(version=version)
        + f'<System name="root">{inside}</System>{experiment}</SystemStructureDescription>'
    )
    return file


def read(file: Path, stop: Fraction | None = None) -> tuple[dict[str, Any], list[str]]:
    return read_system(file, stop)


def connect(start: str, end: str, inside: str = "", more: str = "") -> str:
    ends = []
    for which, text in (("start", start), ("end", end)):
        element, _, connector = text.rpartition(".")
        named = f'{which}Element="{element}" ' if element else ""
        ends.append(f'{named}{which}Connector="{connector}"')
    return f"<Connection {' '.join(ends)} {more}>{inside}</Connection>"
