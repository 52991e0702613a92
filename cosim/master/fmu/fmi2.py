"""FMI 2.0: the functions of a co-simulation FMU that are called, and one instance behind them."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from ctypes import POINTER, c_char_p, c_double, c_int, c_size_t, c_void_p
from functools import cache
from pathlib import Path
from typing import Any

from cosim.base.component import VariableType
from cosim.master.fmu.binding import (
    OK,
    Assignment,
    Beginnings,
    Library,
    Prototype,
    References,
    Texts,
    texts,
    whole_or_real,
)
from cosim.master.fmu.state import FMI2
from cosim.master.kernel.native import function_address, library

_CO_SIMULATION = 1
"""Of fmi2Type."""
_TERMINATED = 3
"""Of fmi2StatusKind."""

TYPES: dict[VariableType, tuple[str, Any]] = {
    VariableType.FLOAT64: ("Real", c_double),
    VariableType.INT32: ("Integer", c_int),
    VariableType.ENUMERATION: ("Integer", c_int),
    VariableType.BOOLEAN: ("Boolean", c_int),
    VariableType.STRING: ("String", c_char_p),
}
"""How the accessors of a type are called, and what they pass."""


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


class Fmi2:
    """One instance; ``environment`` is the address of the log that the kernel writes.

    ``calling`` is told the name of each function before it is called.
    """

    def __init__(
        self, functions: Library, environment: int, calling: Callable[[str], None]
    ) -> None:
        self.handle = 0
        self._calling = calling
        self._functions = functions
        allocate, free = _memory()
        self._callbacks = CallbacksStruct(
            logger=function_address(library().kernel_log_fmi2),
            allocateMemory=allocate,
            freeMemory=free,
            componentEnvironment=environment,
        )

    def instantiate(self, name: str, token: str, resources: Path, *, log_all: bool) -> bool:
        """Make the instance; whether the FMU did."""
        self._calling("fmi2Instantiate")
        self.handle = (
            self._functions["fmi2Instantiate"](
                name.encode(),
                _CO_SIMULATION,
                token.encode(),
                resources.as_uri().encode(),
                self._callbacks,
                0,
                log_all,
            )
            or 0
        )
        return self.handle != 0

    def choose_log_categories(self, categories: Sequence[str]) -> int:
        """Log these categories and no others."""
        if "fmi2SetDebugLogging" not in self._functions:
            return OK
        return self._call("fmi2SetDebugLogging", 1, len(categories), texts(categories))

    def set_values(self, kind: VariableType, reference: int, values: Sequence[Any]) -> int:
        """Set a scalar variable.

        Raises:
            ValueError: the value does not fit the type.
        """
        ready = self.assignment(kind, [reference], values)
        return self._call(ready.function, ready.references, 1, ready.values)

    def assignment(
        self, kind: VariableType, references: Sequence[int], values: Sequence[Any]
    ) -> Assignment:
        """Elements of variables of one type, ready to be set.

        Raises:
            ValueError: a value does not fit the type.
        """
        name, passed = TYPES[kind]
        array = texts(values) if passed is c_char_p else whole_or_real(passed, values)
        which = (ctypes.c_uint32 * len(references))(*references)
        return Assignment(f"fmi2Set{name}", which, array)

    def address(self, function: str) -> int:
        """Where a function begins."""
        return self._functions.address(function)

    def beginnings(self) -> Beginnings:
        """What brings the instance before tick 0."""
        reset = self.address("fmi2Reset") if "fmi2Reset" in self._functions else 0
        return Beginnings(
            reset=reset,
            set_up=self.address("fmi2SetupExperiment"),
            enter=self.address("fmi2EnterInitializationMode"),
            leave=self.address("fmi2ExitInitializationMode"),
        )

    def enter_configuration(self) -> int:
        """FMI 2.0 has no configuration mode."""
        return OK

    def exit_configuration(self) -> int:
        """FMI 2.0 has no configuration mode."""
        return OK

    def set_up_experiment(self, start_time: float, stop_time: float) -> int:
        """Say when the run begins and ends (s)."""
        return self._call("fmi2SetupExperiment", 0, 0.0, start_time, 1, stop_time)

    def enter_initialisation(self, start_time: float, stop_time: float) -> int:
        """Enter initialisation mode; ``set_up_experiment`` has told the times."""
        return self._call("fmi2EnterInitializationMode")

    def exit_initialisation(self) -> int:
        """Leave initialisation mode."""
        return self._call("fmi2ExitInitializationMode")

    def save_state(self) -> tuple[int, bytes]:
        """The status, and the whole state as bytes."""
        return FMI2.save(self._functions, self.handle)

    def load_state(self, content: bytes) -> int:
        """Restore what ``save_state`` returned."""
        return FMI2.load(self._functions, self.handle, content)

    def keep_state(self) -> tuple[int, c_void_p]:
        """The status, and the state as the FMU's own object."""
        return FMI2.keep(self._functions, self.handle)

    def put_state(self, state: c_void_p) -> int:
        """Go back to a state that was kept."""
        return FMI2.put(self._functions, self.handle, state)

    def drop_state(self, state: c_void_p) -> int:
        """Give a kept state back."""
        return FMI2.drop(self._functions, self.handle, state)

    def missing_state_functions(self) -> list[str]:
        """What the library lacks to save and to load a state."""
        return FMI2.missing(self._functions)

    def asks_to_end(self) -> bool:
        """Whether a step was discarded because the model has come to its end (section 4.2.1)."""
        if "fmi2GetBooleanStatus" not in self._functions:
            return False
        found = c_int(0)
        status = self._call("fmi2GetBooleanStatus", _TERMINATED, ctypes.byref(found))
        return status == OK and found.value != 0

    def do_step_address(self) -> int:
        """Where the step function begins."""
        return self._functions.address("fmi2DoStep")

    def accessor_address(self, kind: VariableType, *, is_set: bool) -> int:
        """Where the set or get function of a type begins."""
        return self._functions.address(f"fmi2{'Set' if is_set else 'Get'}{TYPES[kind][0]}")

    def reset(self) -> int | None:
        """Go back to what ``instantiate`` made; ``None`` where the library cannot."""
        return self._call("fmi2Reset") if "fmi2Reset" in self._functions else None

    def terminate(self) -> int:
        """End the run."""
        return self._call("fmi2Terminate")

    def free(self) -> None:
        """Give the instance back."""
        self._calling("fmi2FreeInstance")
        self._functions["fmi2FreeInstance"](self.handle)
        self.handle = 0

    def _call(self, function: str, *arguments: Any) -> int:
        self._calling(function)
        return self._functions[function](self.handle, *arguments)


@cache
def _memory() -> tuple[int, int]:
    """The addresses of ``calloc`` and ``free``, which the standard has the importer provide."""
    runtime = ctypes.CDLL("msvcrt" if sys.platform == "win32" else None)
    return function_address(runtime.calloc), function_address(runtime.free)
