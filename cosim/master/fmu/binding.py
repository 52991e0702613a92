"""The library of an FMU: opened once a process, every function that is called typed.

A library is shared by all instances made from it. Arguments are checked against the prototypes
before native code sees them; what a function returns is handed back, and whoever called judges it.
"""

from __future__ import annotations

import ctypes
import platform
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from cosim.base.component import VariableType
from cosim.base.errors import InputError
from cosim.master.kernel.native import function_address

OK, WARNING, DISCARD = 0, 1, 2
"""The first two let a run go on; after the third one the instance is as it was before the call."""

FATAL = 4
"""The status after which all instances of a library are lost."""

EVENT_FUNCTIONS = (
    "EnterEventMode",
    "EnterStepMode",
    "UpdateDiscreteStates",
    "SetClock",
    "GetClock",
    "GetIntervalDecimal",
    "GetShiftDecimal",
)
"""What is called in event mode, without its prefix."""

Prototype = tuple[Any, tuple[Any, ...]]
"""What a function returns (``None``, a status or a pointer), and its arguments."""

References = ctypes.POINTER(ctypes.c_uint32)
Texts = ctypes.POINTER(ctypes.c_char_p)


@dataclass(frozen=True, slots=True, kw_only=True)
class InstanceWanted:
    """What an instance is made with, in either version of the standard."""

    name: str
    token: str
    """As the description has it, so that the library knows that it belongs to it."""
    resources: Path
    """The folder, which need not be there."""
    log_all: bool
    event_mode: bool
    """Whether event mode is used; FMI 2.0 has none in co-simulation."""
    early_return: bool
    """Whether a step may end early, at an event."""


class Library:
    """An opened shared library with the typed functions of one version of FMI.

    It must have those that every run calls (``needed``); another one is missed when it is called.
    """

    def __init__(
        self, path: Path, prototypes: Mapping[str, Prototype], needed: Iterable[str]
    ) -> None:
        try:
            library = ctypes.CDLL(str(path))
        except OSError as error:
            hint = ""
            if "failed to map segment" in str(error):
                hint = (
                    f"; {path.parent} seems to be where nothing may be executed (noexec): "
                    "COHAPTIC_CACHE_DIR names another folder for unpacked FMUs"
                )
            raise InputError(f"the library {path.name} cannot be loaded: {error}{hint}") from None
        self.path = path
        self.handle: int = library._handle
        """The system's, for unloading it."""
        self._functions: dict[str, Any] = {}
        self._addresses: dict[str, int] = {}
        for name, (result, arguments) in prototypes.items():
            try:
                function = library[name]
            except AttributeError:
                continue
            function.restype, function.argtypes = result, arguments
            self._functions[name] = function
        missing = [name for name in needed if name not in self._functions]
        if missing:
            raise InputError(
                f"the library {path.name} cannot be loaded: it has no function "
                f"{' and none '.join(missing)}"
            )

    def __getitem__(self, function: str) -> Any:
        """A function by its name in the standard.

        Raises:
            InputError: the library lacks it.
        """
        if function not in self._functions:
            raise InputError(f"the library {self.path.name} has no function {function}")
        return self._functions[function]

    def __contains__(self, function: str) -> bool:
        """Whether there is a function of that name."""
        return function in self._functions

    def address(self, function: str) -> int:
        """Where a function begins, for the kernel."""
        if function not in self._addresses:
            self._addresses[function] = function_address(self[function])
        return self._addresses[function]


@dataclass(frozen=True, slots=True)
class Assignment:
    """Elements of variables of one type, as a function of the standard takes them."""

    function: str
    references: Any
    """An array of value references."""
    values: Any
    """An array of as many elements as the variables have."""


@dataclass(frozen=True, slots=True)
class Beginnings:
    """Addresses of what brings an instance before tick 0; 0 where the library has no such."""

    reset: int
    set_up: int
    enter: int
    leave: int


class Binding(Protocol):
    """One instance of an FMU behind its library; each call returns the status that came back.

    ``handle`` is the address of the instance, 0 before it is made and after it was freed.
    """

    handle: int

    def instantiate(self, wanted: InstanceWanted) -> bool:
        """Make the instance; whether the FMU did."""
        ...

    def missing_event_functions(self) -> list[str]:
        """What the library lacks for event mode."""
        ...

    def event_addresses(self) -> list[int]:
        """Where the functions of event mode begin, in the order of ``EVENT_FUNCTIONS``."""
        ...

    def choose_log_categories(self, categories: Sequence[str]) -> int:
        """Log these categories and no others."""
        ...

    def set_values(self, kind: VariableType, reference: int, values: Sequence[Any]) -> int:
        """Set a variable's elements.

        Raises:
            ValueError: a value does not fit the type.
        """
        ...

    def set_texts(
        self, kind: VariableType, references: Sequence[int], contents: Sequence[bytes]
    ) -> int:
        """Set all elements of variables of a type that is a text's."""
        ...

    def get_texts(
        self, kind: VariableType, references: Sequence[int], count: int
    ) -> tuple[int, list[bytes | None]]:
        """The status, and the ``count`` elements of variables of a type that is a text's.

        Raises:
            ValueError: one is longer than what is carried.
        """
        ...

    def enter_configuration(self) -> int:
        """Enter configuration mode."""
        ...

    def exit_configuration(self) -> int:
        """Leave configuration mode."""
        ...

    def set_up_experiment(self, start_time: float, stop_time: float) -> int:
        """Say when the run begins and ends (s), where that has a call of its own."""
        ...

    def enter_initialisation(self, start_time: float, stop_time: float) -> int:
        """Enter initialisation mode."""
        ...

    def set_intervals(self, references: Sequence[int], intervals: Sequence[float]) -> int:
        """Say at which intervals (s) clocks will tick that the importer has the choice of."""
        ...

    def exit_initialisation(self) -> int:
        """Leave initialisation mode."""
        ...

    def save_state(self) -> tuple[int, bytes]:
        """The status, and the whole state as bytes."""
        ...

    def load_state(self, content: bytes) -> int:
        """Restore what ``save_state`` returned."""
        ...

    def look_at_state(self, at: Any) -> int:
        """Have the whole state as bytes in ``at.content``, in the place of the look before."""
        ...

    def keep_state(self) -> tuple[int, Any]:
        """The status, and the state as an object of the binding's own."""
        ...

    def put_state(self, state: Any) -> int:
        """Go back to a state that was kept."""
        ...

    def drop_state(self, state: Any) -> int:
        """Give a kept state back."""
        ...

    def missing_state_functions(self) -> list[str]:
        """What the library lacks to save and to load a state."""
        ...

    def asks_to_end(self) -> tuple[int, bool]:
        """The status, and whether a step was discarded because the model has come to its end."""
        ...

    def do_step_address(self) -> int:
        """Where the step function begins."""
        ...

    def accessor_address(self, kind: VariableType, *, is_set: bool) -> int:
        """Where the set or get function of a type begins."""
        ...

    def reset(self) -> int | None:
        """Go back to what ``instantiate`` made; ``None`` where the library cannot."""
        ...

    def terminate(self) -> int:
        """End the run."""
        ...

    def free(self) -> None:
        """Give the instance back."""
        ...


def platform_folder(version: int) -> str:
    """The folder of this machine's libraries below ``binaries``."""
    machine = platform.machine().lower()
    names = {"amd64": "x86_64", "x64": "x86_64", "arm64": "aarch64"}
    architecture = names.get(machine, machine)
    if version == 3:
        system = {"win32": "windows"}.get(sys.platform, sys.platform)
        return f"{architecture}-{system}"
    return {"win32": "win"}.get(sys.platform, sys.platform) + "64"


def library_suffix() -> str:
    """How shared libraries are called on this machine."""
    return {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


def whole_or_real(kind: Any, values: Iterable[Any]) -> Any:
    """A C array of the values, none of them cut off or wrapped round.

    Raises:
        ValueError: a whole number does not fit.
    """
    given = list(values)
    array = (kind * len(given))(*given)
    if kind not in {ctypes.c_double, ctypes.c_float} and list(array) != given:
        raise ValueError("a whole number does not fit")
    return array


def texts(values: Iterable[str | bytes]) -> Any:
    """A C array of texts in UTF-8."""
    given = [value.encode() if isinstance(value, str) else value for value in values]
    return (ctypes.c_char_p * len(given))(*given)
