"""The binding's prototypes are those of the standard's headers; a library is opened once."""

from __future__ import annotations

import ctypes
import re
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import fmus
from cosim.base.component import VariableType
from cosim.base.errors import InputError
from cosim.master.fmu import fmi2, fmi3, state
from cosim.master.fmu.binding import Prototype
from cosim.master.fmu.instance import Fmu
from cosim.master.fmu.library import take_library
from cosim.master.fmu.loaded.binary import find_binary
from cosim.master.fmu.reading import read_description
from cosim.master.kernel.build import find_kernel
from cosim.master.run.simulation import assemble
from tests.support.master.master_support import scenario_of

HEADERS = Path(fmus.__file__).parent / "fmi" / "headers"
PROTOTYPES = {
    2: fmi2.PROTOTYPES | state.FMI2.prototypes(),
    3: fmi3.PROTOTYPES | state.FMI3.prototypes(),
}
TYPE_FILES = {2: "fmi2TypesPlatform.h", 3: "fmi3PlatformTypes.h"}
C_TYPES: dict[str, Any] = {
    "double": ctypes.c_double,
    "float": ctypes.c_float,
    "int": ctypes.c_int,
    "unsigned int": ctypes.c_uint,
    "size_t": ctypes.c_size_t,
    "bool": ctypes.c_bool,
    "char": ctypes.c_char,
    "char*": ctypes.c_char_p,
    "fmi2Char*": ctypes.c_char_p,
    "fmi3Char*": ctypes.c_char_p,
    "fmi3Byte*": ctypes.POINTER(ctypes.c_uint8),
    "void*": ctypes.c_void_p,
    "void": None,
    **{f"int{n}_t": getattr(ctypes, f"c_int{n}") for n in (8, 16, 32, 64)},
    **{f"uint{n}_t": getattr(ctypes, f"c_uint{n}") for n in (8, 16, 32, 64)},
}
CALLED_ALWAYS = [
    "SetDebugLogging",
    "FreeInstance",
    "EnterInitializationMode",
    "ExitInitializationMode",
    "Terminate",
    "DoStep",
]


def without_comments(text: str) -> str:
    return re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)


def named_types(version: int) -> dict[str, Any]:
    """What each type name of the headers is in C, as ctypes has it."""
    text = without_comments((HEADERS / TYPE_FILES[version]).read_text())
    found = dict(C_TYPES)
    for written, name in re.findall(r"typedef\s+([\w\s]+?\*?)\s*(fmi\d\w+)\s*;", text):
        plain = written.replace("const", "").strip().replace(" *", "*")
        found[name] = found[plain]
    functions = without_comments((HEADERS / f"fmi{version}FunctionTypes.h").read_text())
    for name in re.findall(r"}\s*(fmi\d\w+)\s*;", functions):
        found[name] = ctypes.c_int  # an enumeration; the one structure is met as a pointer
    for name in re.findall(r"\(\*(fmi\d\w+)\)", functions):
        found[name] = ctypes.c_void_p  # a callback
    found["fmi2CallbackFunctions"] = fmi2.CallbacksStruct
    return found


def declared(version: int) -> dict[str, Prototype]:
    """Every function type of the standard."""
    types = named_types(version)
    text = without_comments((HEADERS / f"fmi{version}FunctionTypes.h").read_text())
    found: dict[str, Prototype] = {}
    pattern = r"typedef\s+([\w\s]+?\*?)\s*(fmi\d\w+)TYPE\s*\(([^;]*)\)\s*;"
    for result, name, arguments in re.findall(pattern, text):
        found[name] = (
            types[result.replace("const", "").strip().replace(" *", "*")],
            tuple(argument(part, types) for part in arguments.split(",") if part.strip() != "void"),
        )
    return found


def argument(text: str, types: Mapping[str, Any]) -> Any:
    is_array = "[" in text or "*" in text
    words = re.sub(r"\[.*?\]|\*|\bconst\b", " ", text).split()
    kind = types["void*" if words[0] == "void" else words[0]]
    return ctypes.POINTER(kind) if is_array and words[0] != "void" else kind


@pytest.mark.parametrize("version", [2, 3])
def test_every_prototype_is_the_headers(version: int) -> None:
    standard = declared(version)
    for name, prototype in PROTOTYPES[version].items():
        assert prototype == standard[name], name
    assert {f"fmi{version}{name}" for name in CALLED_ALWAYS} <= set(PROTOTYPES[version])


@pytest.mark.parametrize("version", [2, 3])
def test_every_number_and_text_of_the_standard_can_be_set_and_got(version: int) -> None:
    typed = {
        name
        for name in declared(version)
        if re.fullmatch(r"fmi\d[GS]et(Real|Integer|U?Int\d+|Float\d+|Boolean|String)", name)
    }
    assert typed <= set(PROTOTYPES[version])
    assert len(typed) == (8 if version == 2 else 24)


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_instances_share_one_library(flavour: str) -> None:
    description = read_description(fmus.find("hand", flavour))
    first, second = (Fmu(name, description, substeps=1) for name in ("one", "two"))
    for fmu in (first, second):
        fmu.instantiate()
    assert first.instance != second.instance
    assert first.do_step == second.do_step
    binary = find_binary(description)
    assert take_library(binary, description.version) is take_library(binary, description.version)
    for fmu in (first, second):
        fmu.close()
        fmu.close()


def test_a_library_without_the_standards_functions_is_refused() -> None:
    with pytest.raises(InputError, match="has no function fmi3InstantiateCoSimulation and none"):
        take_library(find_kernel(), 3)


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        (VariableType.INT32, 2**31),
        (VariableType.INT32, -(2**31) - 1),
        (VariableType.BOOLEAN, "yes"),
        (VariableType.FLOAT64, "1"),
        (VariableType.FLOAT64, 10**400),
    ],
)
@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_a_value_that_its_type_cannot_hold_never_reaches_the_fmu(
    flavour: str, kind: VariableType, value: Any
) -> None:
    description = read_description(fmus.find("virtual_coupler", flavour))
    fmu = Fmu("c", description, substeps=1)
    fmu.instantiate()
    with pytest.raises((ValueError, TypeError, OverflowError, ctypes.ArgumentError)):
        fmu._bound.set_values(kind, 1, [value])
    name = next(n for n, v in description.variables.items() if v.type is VariableType.INT32)
    with pytest.raises(InputError, match=rf"c: {name} = {2**31} does not fit its type, Int32"):
        fmu.values.set({name: [2**31]})
    fmu.close()


def test_an_fmu_starts_in_less_than_half_a_millisecond(tmp_path: Path) -> None:
    components = {f"hand_{n}": {"fmu": "hand", "rate": 1024} for n in range(128)}
    written = {"duration": 0.125, "components": components, "record": []}
    times: list[float] = []
    for _ in range(5):
        with assemble(scenario_of(tmp_path, written)) as simulation:
            began = time.thread_time()
            simulation.start(128)
            times.append((time.thread_time() - began) / len(components))
    assert min(times) < 0.4e-3
