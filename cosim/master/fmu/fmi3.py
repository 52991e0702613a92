"""FMI 3.0: the functions of a co-simulation FMU that are called, and one instance behind them."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from ctypes import POINTER, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint8, c_void_p
from typing import Any

from cosim.base.component import VariableType
from cosim.base.texts import MOST_BYTES
from cosim.master.fmu.binding import OK, InstanceWanted, Library, Prototype, References, Texts
from cosim.master.fmu.bound import Bound, Types
from cosim.master.fmu.state import FMI3
from cosim.master.kernel.native import function_address, library

BinaryPointer = POINTER(c_uint8)
"""``fmi3Binary``."""

TYPES: Types = {
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
    **{
        f"fmi3{verb}Binary": (
            c_int,
            (c_void_p, References, c_size_t, POINTER(c_size_t), POINTER(BinaryPointer), c_size_t),
        )
        for verb in ("Get", "Set")
    },
    "fmi3EnterEventMode": (c_int, (c_void_p,)),
    "fmi3EnterStepMode": (c_int, (c_void_p,)),
    "fmi3UpdateDiscreteStates": (c_int, (c_void_p, *5 * (POINTER(c_bool),), POINTER(c_double))),
    **{
        f"fmi3{verb}Clock": (c_int, (c_void_p, References, c_size_t, POINTER(c_bool)))
        for verb in ("Get", "Set")
    },
    "fmi3GetIntervalDecimal": (
        c_int,
        (c_void_p, References, c_size_t, POINTER(c_double), POINTER(c_int)),
    ),
    "fmi3SetIntervalDecimal": (c_int, (c_void_p, References, c_size_t, POINTER(c_double))),
    "fmi3GetShiftDecimal": (c_int, (c_void_p, References, c_size_t, POINTER(c_double))),
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


class Fmi3(Bound):
    """One instance; ``environment`` is the address of the log that the kernel writes.

    ``calling`` is told the name of each function before it is called.
    """

    def __init__(
        self, functions: Library, environment: int, calling: Callable[[str], None]
    ) -> None:
        super().__init__("fmi3", TYPES, FMI3, functions, calling)
        self._environment = environment

    def instantiate(self, wanted: InstanceWanted) -> bool:
        """Make the instance; whether the FMU did."""
        self._calling("fmi3InstantiateCoSimulation")
        self.handle = (
            self._functions["fmi3InstantiateCoSimulation"](
                wanted.name.encode(),
                wanted.token.encode(),
                # FMI 3 wants NULL where there are none.
                f"{wanted.resources}/".encode() if wanted.resources.is_dir() else None,
                False,
                wanted.log_all,
                wanted.event_mode,
                wanted.early_return,
                None,
                0,
                self._environment,
                function_address(library().kernel_log_fmi3),
                None,
            )
            or 0
        )
        return self.handle != 0

    def _set(self, kind: VariableType, references: Sequence[int], values: Sequence[Any]) -> int:
        if kind is not VariableType.BINARY:
            return super()._set(kind, references, values)
        sizes = (c_size_t * len(values))(*map(len, values))
        bytes_of = [(c_uint8 * len(value)).from_buffer_copy(value) for value in values]
        contents = (BinaryPointer * len(values))(
            *(ctypes.cast(each, BinaryPointer) for each in bytes_of)
        )
        which = self.references(references)
        return self._call("SetBinary", which, len(references), sizes, contents, len(values))

    def get_texts(
        self, kind: VariableType, references: Sequence[int], count: int
    ) -> tuple[int, list[bytes | None]]:
        """The status, and the ``count`` elements of String or Binary variables, copied at once.

        Raises:
            ValueError: one is longer than what is carried.
        """
        if kind is not VariableType.BINARY:
            return super().get_texts(kind, references, count)
        sizes, contents = (c_size_t * count)(), (BinaryPointer * count)()
        which = self.references(references)
        status = self._call("GetBinary", which, len(references), sizes, contents, count)
        if not self.is_well(status):
            return status, []
        if max(sizes) > MOST_BYTES:
            raise ValueError(
                f"a binary value of {max(sizes)} bytes is longer than the {MOST_BYTES} bytes that "
                "are carried"
            )
        pairs = zip(contents, sizes, strict=True)
        return status, [_copied(at, size) for at, size in pairs]

    def enter_configuration(self) -> int:
        """Enter configuration mode."""
        return self._call("EnterConfigurationMode")

    def exit_configuration(self) -> int:
        """Leave configuration mode."""
        return self._call("ExitConfigurationMode")

    def set_up_experiment(self, start_time: float, stop_time: float) -> int:
        """FMI 3.0 is told with ``enter_initialisation``."""
        return OK

    def enter_initialisation(self, start_time: float, stop_time: float) -> int:
        """Enter initialisation mode for a run from ``start_time`` to ``stop_time`` (s)."""
        times = (start_time, True, stop_time)
        return self._call("EnterInitializationMode", False, 0.0, *times)

    def set_intervals(self, references: Sequence[int], intervals: Sequence[float]) -> int:
        """Say at which intervals (s) clocks will tick that the importer has the choice of.

        A library without the function cannot be told, and has what its description says.
        """
        if "fmi3SetIntervalDecimal" not in self._functions:
            return OK
        given = (c_double * len(intervals))(*intervals)
        which = self.references(references)
        return self._call("SetIntervalDecimal", which, len(references), given)

    def asks_to_end(self) -> tuple[int, bool]:
        """FMI 3.0 says so with the step itself."""
        return OK, False


def _copied(address: Any, size: int) -> bytes | None:
    """Bytes of the FMU's own; ``None`` where it says that there are some and does not say where."""
    if size == 0:
        return b""
    return ctypes.string_at(address, size) if address else None
