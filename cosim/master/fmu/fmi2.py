"""FMI 2.0: the functions of a co-simulation FMU that are called, and one instance behind them."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from ctypes import POINTER, c_char_p, c_double, c_int, c_size_t, c_void_p
from functools import cache

from cosim.base.component import VariableType
from cosim.master.fmu.binding import OK, InstanceWanted, Library, Prototype, References, Texts
from cosim.master.fmu.bound import Bound, Types
from cosim.master.fmu.state import FMI2
from cosim.master.kernel.native import function_address, library

_CO_SIMULATION = 1
"""Of fmi2Type."""
_TERMINATED = 3
"""Of fmi2StatusKind."""

TYPES: Types = {
    VariableType.FLOAT64: ("Real", c_double),
    VariableType.INT32: ("Integer", c_int),
    VariableType.ENUMERATION: ("Integer", c_int),
    VariableType.BOOLEAN: ("Boolean", c_int),
    VariableType.STRING: ("String", c_char_p),
}


class CallbacksStruct(ctypes.Structure):
    """``fmi2CallbackFunctions``; functions by their addresses."""

    _fields_ = [
        ("logger", c_void_p),
        ("allocateMemory", c_void_p),
        ("freeMemory", c_void_p),
        ("stepFinished", c_void_p),
        ("componentEnvironment", c_void_p),
    ]


PROTOTYPES: dict[str, Prototype] = {
    "fmi2SetDebugLogging": (c_int, (c_void_p, c_int, c_size_t, Texts)),
    "fmi2Instantiate": (
        c_void_p,
        (c_char_p, c_int, c_char_p, c_char_p, POINTER(CallbacksStruct), c_int, c_int),
    ),
    "fmi2FreeInstance": (None, (c_void_p,)),
    "fmi2SetupExperiment": (c_int, (c_void_p, c_int, c_double, c_double, c_int, c_double)),
    "fmi2EnterInitializationMode": (c_int, (c_void_p,)),
    "fmi2ExitInitializationMode": (c_int, (c_void_p,)),
    "fmi2Terminate": (c_int, (c_void_p,)),
    "fmi2Reset": (c_int, (c_void_p,)),
    **{
        f"fmi2{verb}{name}": (c_int, (c_void_p, References, c_size_t, POINTER(kind)))
        for name, kind in TYPES.values()
        for verb in ("Get", "Set")
    },
    "fmi2DoStep": (c_int, (c_void_p, c_double, c_double, c_int)),
    "fmi2GetBooleanStatus": (c_int, (c_void_p, c_int, POINTER(c_int))),
}


NEEDED = (
    "fmi2Instantiate",
    "fmi2SetupExperiment",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2DoStep",
    "fmi2Terminate",
    "fmi2FreeInstance",
)
"""What every run calls."""


class Fmi2(Bound):
    """One instance; ``environment`` is the address of the log that the kernel writes.

    ``calling`` is told the name of each function before it is called.
    """

    def __init__(
        self, functions: Library, environment: int, calling: Callable[[str], None]
    ) -> None:
        super().__init__("fmi2", TYPES, FMI2, functions, calling)
        allocate, free = _memory()
        self._callbacks = CallbacksStruct(
            logger=function_address(library().kernel_log_fmi2),
            allocateMemory=allocate,
            freeMemory=free,
            componentEnvironment=environment,
        )

    def instantiate(self, wanted: InstanceWanted) -> bool:
        """Make the instance; whether the FMU did."""
        self._calling("fmi2Instantiate")
        self.handle = (
            self._functions["fmi2Instantiate"](
                wanted.name.encode(),
                _CO_SIMULATION,
                wanted.token.encode(),
                wanted.resources.as_uri().encode(),
                self._callbacks,
                0,
                wanted.log_all,
            )
            or 0
        )
        return self.handle != 0

    def enter_configuration(self) -> int:
        """FMI 2.0 has no configuration mode."""
        return OK

    def exit_configuration(self) -> int:
        """FMI 2.0 has no configuration mode."""
        return OK

    def set_up_experiment(self, start_time: float, stop_time: float) -> int:
        """Say when the run begins and ends (s)."""
        return self._call("SetupExperiment", 0, 0.0, start_time, 1, stop_time)

    def enter_initialisation(self, start_time: float, stop_time: float) -> int:
        """Enter initialisation mode; ``set_up_experiment`` has told the times."""
        return self._call("EnterInitializationMode")

    def set_intervals(self, references: Sequence[int], intervals: Sequence[float]) -> int:
        """FMI 2.0 has no clocks."""
        return OK

    def asks_to_end(self) -> tuple[int, bool]:
        """Whether a step was discarded because the model has come to its end (section 4.2.1)."""
        if "fmi2GetBooleanStatus" not in self._functions:
            return OK, False
        found = c_int(0)
        status = self._call("GetBooleanStatus", _TERMINATED, ctypes.byref(found))
        return status, self.is_well(status) and found.value != 0


@cache
def _memory() -> tuple[int, int]:
    """The addresses of ``calloc`` and ``free``, which the standard has the importer provide."""
    runtime = ctypes.CDLL("msvcrt" if sys.platform == "win32" else None)
    return function_address(runtime.calloc), function_address(runtime.free)
