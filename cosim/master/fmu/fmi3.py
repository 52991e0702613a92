"""FMI 3.0: the functions of a co-simulation FMU that are called, and one instance behind them."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from ctypes import POINTER, c_bool, c_char_p, c_double, c_int, c_size_t, c_void_p
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
from cosim.master.fmu.state import FMI3
from cosim.master.kernel.native import function_address, library

TYPES: dict[VariableType, tuple[str, Any]] = {
    VariableType.FLOAT32: ("Float32", ctypes.c_float),
    VariableType.FLOAT64: ("Float64", c_double),
    VariableType.INT8: ("Int8", ctypes.c_int8),
    VariableType.UINT8: ("UInt8", ctypes.c_uint8),
    VariableType.INT16: ("Int16", ctypes.c_int16),
    VariableType.UINT16: ("UInt16", ctypes.c_uint16),
    VariableType.INT32: ("Int32", ctypes.c_int32),
    VariableType.UINT32: ("UInt32", ctypes.c_uint32),
    VariableType.INT64: ("Int64", ctypes.c_int64),
    VariableType.UINT64: ("UInt64", ctypes.c_uint64),
    VariableType.ENUMERATION: ("Int64", ctypes.c_int64),
    VariableType.BOOLEAN: ("Boolean", c_bool),
    VariableType.STRING: ("String", c_char_p),
}
"""How the accessors of a type are called, and what they pass."""

PROTOTYPES: dict[str, Prototype] = {
    "fmi3SetDebugLogging": (c_int, (c_void_p, c_bool, c_size_t, Texts)),
    "fmi3InstantiateCoSimulation": (
        c_void_p,
        (
            c_char_p,  # instance name
            c_char_p,  # instantiation token
            c_char_p,  # resource path
            c_bool,  # visible
            c_bool,  # logging on
            c_bool,  # event mode used
            c_bool,  # early return allowed
            References,  # required intermediate variables
            c_size_t,
            c_void_p,  # instance environment
            c_void_p,  # log message
            c_void_p,  # intermediate update
        ),
    ),
    "fmi3FreeInstance": (None, (c_void_p,)),
    "fmi3EnterInitializationMode": (
        c_int,
        (c_void_p, c_bool, c_double, c_double, c_bool, c_double),
    ),
    "fmi3ExitInitializationMode": (c_int, (c_void_p,)),
    "fmi3EnterConfigurationMode": (c_int, (c_void_p,)),
    "fmi3ExitConfigurationMode": (c_int, (c_void_p,)),
    "fmi3Terminate": (c_int, (c_void_p,)),
    "fmi3Reset": (c_int, (c_void_p,)),
    **{
        f"fmi3{verb}{name}": (c_int, (c_void_p, References, c_size_t, POINTER(kind), c_size_t))
        for name, kind in TYPES.values()
        for verb in ("Get", "Set")
    },
    "fmi3DoStep": (
        c_int,
        (
            c_void_p,
            c_double,
            c_double,
            c_bool,
            POINTER(c_bool),
            POINTER(c_bool),
            POINTER(c_bool),
            POINTER(c_double),
        ),
    ),
}


NEEDED = (
    "fmi3InstantiateCoSimulation",
    "fmi3EnterInitializationMode",
    "fmi3ExitInitializationMode",
    "fmi3DoStep",
    "fmi3Terminate",
    "fmi3FreeInstance",
)
"""What every run calls."""


class Fmi3:
    """One instance; ``environment`` is the address of the log that the kernel writes.

    ``calling`` is told the name of each function before it is called.
    """

    def __init__(
        self, functions: Library, environment: int, calling: Callable[[str], None]
    ) -> None:
        self.handle = 0
        self._calling = calling
        self._functions = functions
        self._environment = environment

    def instantiate(self, name: str, token: str, resources: Path, *, log_all: bool) -> bool:
        """Make the instance; whether the FMU did. Event mode and early return are not used."""
        self._calling("fmi3InstantiateCoSimulation")
        self.handle = (
            self._functions["fmi3InstantiateCoSimulation"](
                name.encode(),
                token.encode(),
                # FMI 3 wants NULL where there are none.
                f"{resources}/".encode() if resources.is_dir() else None,
                False,
                log_all,
                False,
                False,
                None,
                0,
                self._environment,
                function_address(library().kernel_log_fmi3),
                None,
            )
            or 0
        )
        return self.handle != 0

    def choose_log_categories(self, categories: Sequence[str]) -> int:
        """Log these categories and no others."""
        if "fmi3SetDebugLogging" not in self._functions:
            return OK
        return self._call("fmi3SetDebugLogging", True, len(categories), texts(categories))

    def set_values(self, kind: VariableType, reference: int, values: Sequence[Any]) -> int:
        """Set a variable's elements.

        Raises:
            ValueError: a value does not fit the type.
        """
        ready = self.assignment(kind, [reference], values)
        return self._call(ready.function, ready.references, 1, ready.values, len(values))

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
        return Assignment(f"fmi3Set{name}", which, array)

    def address(self, function: str) -> int:
        """Where a function begins."""
        return self._functions.address(function)

    def beginnings(self) -> Beginnings:
        """What brings the instance before tick 0."""
        reset = self.address("fmi3Reset") if "fmi3Reset" in self._functions else 0
        return Beginnings(
            reset=reset,
            set_up=0,
            enter=self.address("fmi3EnterInitializationMode"),
            leave=self.address("fmi3ExitInitializationMode"),
        )

    def enter_configuration(self) -> int:
        """Enter configuration mode."""
        return self._call("fmi3EnterConfigurationMode")

    def exit_configuration(self) -> int:
        """Leave configuration mode."""
        return self._call("fmi3ExitConfigurationMode")

    def set_up_experiment(self, start_time: float, stop_time: float) -> int:
        """FMI 3.0 is told with ``enter_initialisation``."""
        return OK

    def enter_initialisation(self, start_time: float, stop_time: float) -> int:
        """Enter initialisation mode for a run from ``start_time`` to ``stop_time`` (s)."""
        times = (start_time, True, stop_time)
        return self._call("fmi3EnterInitializationMode", False, 0.0, *times)

    def exit_initialisation(self) -> int:
        """Leave initialisation mode."""
        return self._call("fmi3ExitInitializationMode")

    def save_state(self) -> tuple[int, bytes]:
        """The status, and the whole state as bytes."""
        return FMI3.save(self._functions, self.handle)

    def load_state(self, content: bytes) -> int:
        """Restore what ``save_state`` returned."""
        return FMI3.load(self._functions, self.handle, content)

    def keep_state(self) -> tuple[int, c_void_p]:
        """The status, and the state as the FMU's own object."""
        return FMI3.keep(self._functions, self.handle)

    def put_state(self, state: c_void_p) -> int:
        """Go back to a state that was kept."""
        return FMI3.put(self._functions, self.handle, state)

    def drop_state(self, state: c_void_p) -> int:
        """Give a kept state back."""
        return FMI3.drop(self._functions, self.handle, state)

    def missing_state_functions(self) -> list[str]:
        """What the library lacks to save and to load a state."""
        return FMI3.missing(self._functions)

    def asks_to_end(self) -> bool:
        """FMI 3.0 says so with the step itself."""
        return False

    def do_step_address(self) -> int:
        """Where the step function begins."""
        return self._functions.address("fmi3DoStep")

    def accessor_address(self, kind: VariableType, *, is_set: bool) -> int:
        """Where the set or get function of a type begins."""
        return self._functions.address(f"fmi3{'Set' if is_set else 'Get'}{TYPES[kind][0]}")

    def reset(self) -> int | None:
        """Go back to what ``instantiate`` made; ``None`` where the library cannot."""
        return self._call("fmi3Reset") if "fmi3Reset" in self._functions else None

    def terminate(self) -> int:
        """End the run."""
        return self._call("fmi3Terminate")

    def free(self) -> None:
        """Give the instance back."""
        self._calling("fmi3FreeInstance")
        self._functions["fmi3FreeInstance"](self.handle)
        self.handle = 0

    def _call(self, function: str, *arguments: Any) -> int:
        self._calling(function)
        return self._functions[function](self.handle, *arguments)
