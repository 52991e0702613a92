"""FMUs under test: every model found, and one driver for all flavours on FMPy's raw interface."""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.fmi3 import FMU3Slave

from fmus import find, model_names, probe
from fmus.archive import FLAVOURS
from fmus.builder import Source, source_of
from tests.support.scratch import scratch_folder

STEP = 1 / 1024
MODELS = model_names()
PROBES = probe.probe_names()
EVERY = [(name, flavour) for name in (*MODELS, *PROBES) for flavour in FLAVOURS]


def source(name: str) -> Source:
    return probe.source_of(name) if name in PROBES else source_of(name)


def path_of(name: str, flavour: str = "fmi3") -> Path:
    return probe.find(name, flavour) if name in PROBES else find(name, flavour)


def step_of(name: str) -> float:
    return source(name).model.default_step


@functools.cache
def unpacked(name: str, flavour: str) -> tuple[str, Any]:
    folder = extract(str(path_of(name, flavour)), str(scratch_folder("test")))
    return str(folder), read_model_description(str(folder), validate=False)


class Refused(Exception):
    """A call did not return OK; ``status`` is 2 discard, 3 error, 4 fatal."""

    def __init__(self, status: int) -> None:
        super().__init__(status)
        self.status = status


class Fmu:
    """One instance, values by name (arrays whole). ``log`` collects what it says."""

    def __init__(self, name: str, flavour: str = "fmi3", *, logging: bool = False) -> None:
        folder, self.description = unpacked(name, flavour)
        self.fmi2 = flavour == "fmi2"
        self.log: list[tuple[int, str, str]] = []
        self.time = 0.0
        self.variables = {v.name: v for v in self.description.modelVariables}
        arguments = {
            "guid": self.description.guid,
            "unzipDirectory": folder,
            "modelIdentifier": name,
            "instanceName": "test",
        }
        if self.fmi2:
            self.fmu = FMU2Slave(**arguments)
            self.callbacks = fmi2CallbackFunctions()
            self.callbacks.logger = fmi2CallbackLoggerTYPE(self._log2)
            self.fmu.instantiate(callbacks=self.callbacks, loggingOn=logging)
        else:
            self.fmu = FMU3Slave(**arguments)
            self.fmu.instantiate(loggingOn=logging, logMessage=self._log3)
        self.library = self.fmu.dll
        self.component = self.fmu.component

    def _log2(self, _env: Any, _name: Any, status: int, category: bytes, message: bytes) -> None:
        self.log.append((status, category.decode(), message.decode()))

    def _log3(self, _env: Any, status: int, category: bytes, message: bytes) -> None:
        self.log.append((status, category.decode(), message.decode()))

    def call(self, function: str, *arguments: Any) -> None:
        """Call ``fmi2…`` or ``fmi3…`` by what follows the number."""
        name = f"fmi{2 if self.fmi2 else 3}{function}"
        pointer = getattr(self.library, name)
        pointer.argtypes = None
        pointer.restype = ctypes.c_int
        status = pointer(ctypes.c_void_p(self.component), *arguments)
        if status != 0:
            raise Refused(status)

    def kind(self, name: str) -> str:
        kind = self.variables[name].type
        if self.fmi2:
            return {"Enumeration": "Integer"}.get(kind, kind)
        return {"Enumeration": "Int64"}.get(kind, kind)

    def shape(self, name: str) -> int:
        return int(np.prod(self.variables[name].shape or (1,)))

    def get(self, name: str) -> Any:
        kind, count = self.kind(name), self.shape(name)
        values = (self._c(kind) * count)()
        reference = ctypes.c_uint32(self.variables[name].valueReference)
        sizes = [ctypes.c_size_t(count)] if not self.fmi2 else []
        self.call(f"Get{kind}", ctypes.byref(reference), ctypes.c_size_t(1), values, *sizes)
        return list(values) if self.variables[name].shape else values[0]

    def set(self, name: str, value: Any) -> None:
        kind, count = self.kind(name), self.shape(name)
        given = list(value) if isinstance(value, list | tuple | np.ndarray) else [value]
        values = (self._c(kind) * count)(*(v.encode() if isinstance(v, str) else v for v in given))
        reference = ctypes.c_uint32(self.variables[name].valueReference)
        sizes = [ctypes.c_size_t(count)] if not self.fmi2 else []
        self.call(f"Set{kind}", ctypes.byref(reference), ctypes.c_size_t(1), values, *sizes)

    def enter(self, start: float = 0.0, stop_time: float | None = None) -> None:
        stop = (stop_time is not None, ctypes.c_double(stop_time or 0.0))
        arguments = (False, ctypes.c_double(0), ctypes.c_double(start), *stop)
        self.time = start
        if self.fmi2:
            self.call("SetupExperiment", *arguments)
            self.call("EnterInitializationMode")
        else:
            self.call("EnterInitializationMode", *arguments)

    def start(self, start: float = 0.0, stop_time: float | None = None) -> Fmu:
        self.enter(start, stop_time)
        self.call("ExitInitializationMode")
        return self

    def step(self, h: float = STEP) -> None:
        times = (ctypes.c_double(self.time), ctypes.c_double(h), False)
        if self.fmi2:
            self.call("DoStep", *times)
        else:
            flags = [ctypes.c_bool() for _ in range(3)]
            last = ctypes.c_double()
            self.call("DoStep", *times, *(ctypes.byref(x) for x in (*flags, last)))
        self.time += h

    def _c(self, kind: str) -> Any:
        if kind == "Boolean":
            return ctypes.c_int32 if self.fmi2 else ctypes.c_bool
        return _C[kind]

    def names(self, *causalities: str) -> list[str]:
        return [name for name, v in self.variables.items() if v.causality in causalities]

    def bits(self, *causalities: str) -> bytes:
        """The bits of all variables of some causalities, outputs unless said otherwise."""
        out = bytearray()
        for name in self.names(*(causalities or ("output",))):
            value = self.get(name)
            for each in value if isinstance(value, list) else [value]:
                out += np.float64(each).tobytes() if self._real(name) else repr(each).encode()
        return bytes(out)

    def _real(self, name: str) -> bool:
        return self.kind(name) in {"Real", "Float64"}

    def __enter__(self) -> Fmu:
        return self

    def __exit__(self, *error: object) -> None:
        free = getattr(self.library, f"fmi{2 if self.fmi2 else 3}FreeInstance")
        free.argtypes = None
        free(ctypes.c_void_p(self.component))


_C: dict[str, Any] = {
    "Real": ctypes.c_double,
    "Float64": ctypes.c_double,
    "Integer": ctypes.c_int32,
    "Int32": ctypes.c_int32,
    "Int64": ctypes.c_int64,
    "String": ctypes.c_char_p,
}
