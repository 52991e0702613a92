"""A loaded FMU: instantiated, given its parameters, initialised, stepped by the kernel, freed."""

from __future__ import annotations

import ctypes
import importlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from cosim.base.component import Causality, VariableType
from cosim.base.errors import CohapticError, InputError, RunError
from cosim.master.assembly.clock import Clock
from cosim.master.fmu.description import FmuDescription
from cosim.master.kernel.native import LogStruct, function_address, library
from cosim.scenario.build.timebase import hertz

LOG_BYTES = 8192
STATUS_NAMES = ("ok", "warning", "discard", "error", "fatal", "pending")

_FMI2_TERMINATED = 3
"""Of fmi2StatusKind."""
_NAMES_2 = {
    VariableType.FLOAT64: "Real",
    VariableType.INT32: "Integer",
    VariableType.ENUMERATION: "Integer",
    VariableType.BOOLEAN: "Boolean",
    VariableType.STRING: "String",
}


class Fmu:
    """One instance of a co-simulation FMU of FMI 2.0 or 3.0.

    ``close`` is safe at any time and more than once.
    """

    def __init__(self, component: str, description: FmuDescription, *, substeps: int) -> None:
        self.component = component
        self.description = description
        self.version = description.version
        self.substeps = substeps
        self._text = ctypes.create_string_buffer(LOG_BYTES)
        self._log = LogStruct(ctypes.cast(self._text, ctypes.c_char_p), LOG_BYTES, 0, 0)
        self._fmu: Any = None
        self._initialised = False

    @property
    def instance(self) -> int:
        """Address of the instance."""
        return self._fmu.component

    @property
    def do_step(self) -> int:
        """Address of the step function."""
        return function_address(getattr(self._fmu.dll, f"fmi{self.version}DoStep"))

    def accessor(self, kind: VariableType, *, is_set: bool) -> int:
        """Address of the set or get function of a type."""
        verb = "Set" if is_set else "Get"
        return function_address(
            getattr(self._fmu.dll, f"fmi{self.version}{verb}{self._name(kind)}")
        )

    def reference(self, variable: str) -> int:
        """The value reference of a variable."""
        return self.description.references[variable]

    def messages(self) -> list[str]:
        """What the FMU logged last, oldest first, each line once."""
        text = self._text.raw[: self._log.used].decode(errors="replace")
        return list(dict.fromkeys(line.strip() for line in text.splitlines() if line.strip()))

    def instantiate(self) -> None:
        """Load the library and create the instance.

        Raises:
            InputError: no library for this platform, or the FMU refuses to be instantiated.
        """
        self._fmu = self._load()
        fmi2: Any = importlib.import_module("fmpy.fmi2")
        name = self.component.encode()
        token = self.description.token.encode()
        resources = self.description.folder / "resources"
        categories = _error_categories(self.description.log_categories)
        log_all = not categories
        environment = ctypes.addressof(self._log)
        if self.version == 2:
            self._callbacks = self._fmi2_callbacks(fmi2, environment)
            instance = self._fmu.fmi2Instantiate(
                name,
                fmi2.fmi2CoSimulation,
                token,
                resources.as_uri().encode(),
                ctypes.byref(self._callbacks),
                fmi2.fmi2False,
                fmi2.fmi2True if log_all else fmi2.fmi2False,
            )
        else:
            fmi3: Any = importlib.import_module("fmpy.fmi3")
            self._log_message = fmi3.fmi3LogMessageCallback(
                function_address(library().kernel_log_fmi3)
            )
            instance = self._fmu.fmi3InstantiateCoSimulation(
                name,
                token,
                (str(resources) + "/").encode(),
                False,
                log_all,
                False,  # event mode is not used
                False,  # early return is not allowed
                None,
                0,
                environment,
                self._log_message,
                fmi3.fmi3IntermediateUpdateCallback(),
            )
        if not instance:
            raise InputError(
                f"{self.component}: the FMU {self.description.path.name} could not be "
                f"instantiated{self._said()}"
            )
        self._fmu.component = instance
        if categories:
            self._choose_log_categories(categories)

    def set_values(self, values: Mapping[str, list[Any]]) -> None:
        """Set parameters or start values before initialisation; ``configure`` comes first.

        Raises:
            InputError: the FMU refuses one.
        """
        self._set_each({n: e for n, e in values.items() if not self._is_structural(n)})

    def _is_structural(self, variable: str) -> bool:
        causality = self.description.variables[variable].causality
        return causality is Causality.STRUCTURAL_PARAMETER

    def _set_each(self, values: Mapping[str, list[Any]]) -> None:
        for name, elements in values.items():
            kind = self.description.variables[name].type
            try:
                self._set(kind, [self.reference(name)], elements)
            except Exception as error:  # FMPy's FMICallException, or ctypes refusing a value
                raise InputError(
                    f"{self.component}: the FMU refuses {name} = {_show(elements)}{self._said()}"
                ) from error

    def configure(self, values: Mapping[str, list[Any]]) -> None:
        """Set structural parameters in FMI 3's configuration mode.

        Raises:
            InputError: the FMU refuses one, or all of them together.
            RunError: it failed for good.
        """
        structural = {n: e for n, e in values.items() if self._is_structural(n)}
        if not structural:
            return
        self._call("enter configuration mode", self._fmu.enterConfigurationMode)
        self._set_each(structural)
        self._call("leave configuration mode", self._fmu.exitConfigurationMode)

    def enter_initialisation(self, stop_time: float) -> None:
        """Set up the experiment and enter initialisation mode at time 0.

        Raises:
            InputError: the FMU refuses to.
            RunError: it failed for good.
        """
        fmu = self._fmu
        if self.version == 2:
            self._call(
                "set up the experiment",
                lambda: fmu.setupExperiment(startTime=0.0, stopTime=stop_time),
            )
            self._call("enter initialisation mode", fmu.enterInitializationMode)
        else:
            self._call(
                "enter initialisation mode",
                lambda: fmu.enterInitializationMode(startTime=0.0, stopTime=stop_time),
            )

    def exit_initialisation(self) -> None:
        """Leave initialisation mode, ready to step.

        Raises:
            InputError: the FMU refuses to: its parameters and inputs do not go together.
            RunError: it failed for good.
        """
        self._call("leave initialisation mode", self._fmu.exitInitializationMode)
        self._initialised = True

    def asks_to_end(self) -> bool:
        """After a step that was discarded: whether it was because the model has come to its end.

        FMI 3 says so with the step itself; FMI 2 is asked for it (section 4.2.1, fmi2Terminated).
        """
        if self.version != 2:
            return False
        found = ctypes.c_int(0)
        ask = self._fmu.dll.fmi2GetBooleanStatus
        return ask(self._fmu.component, _FMI2_TERMINATED, ctypes.byref(found)) == 0 and bool(
            found.value
        )

    def close(self, *, failed: bool = False) -> None:
        """Terminate and free. ``failed``: an error status was met, so only freeing is allowed."""
        fmu, self._fmu = self._fmu, None
        if fmu is None or not fmu.component:
            return
        try:
            if self._initialised and not failed:
                fmu.terminate()
        except Exception:  # closing must reach every component
            return
        finally:
            # The library stays loaded: other instances may share it.
            free = fmu.fmi2FreeInstance if self.version == 2 else fmu.fmi3FreeInstance
            free(fmu.component)
            fmu.component = None

    def _load(self) -> Any:
        description = self.description
        binary = find_binary(description)
        module: Any = importlib.import_module(f"fmpy.fmi{self.version}")
        slave = module.FMU2Slave if self.version == 2 else module.FMU3Slave
        try:
            return slave(
                guid=description.token,
                unzipDirectory=str(description.folder),
                modelIdentifier=description.model_identifier,
                instanceName=self.component,
            )
        except Exception as error:  # FMPy raises bare exceptions
            raise InputError(
                f"{self.component}: the library {binary.name} of {description.path.name} cannot be "
                f"loaded: {error}"
            ) from None

    def _fmi2_callbacks(self, fmi2: Any, environment: int) -> Any:
        fmpy: Any = importlib.import_module("fmpy")
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(function_address(library().kernel_log_fmi2))
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(
            function_address(fmpy.calloc)
        )
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(function_address(fmpy.free))
        callbacks.componentEnvironment = environment
        return callbacks

    def _choose_log_categories(self, categories: list[str]) -> None:
        words = (ctypes.c_char_p * len(categories))(*(word.encode() for word in categories))
        function = getattr(self._fmu, f"fmi{self.version}SetDebugLogging")
        self._call(
            "choose what is logged", lambda: function(self.instance, True, len(words), words)
        )

    def _set(self, kind: VariableType, references: list[int], values: list[Any]) -> None:
        setter = getattr(self._fmu, f"set{self._name(kind)}")
        setter(references, values)

    def _name(self, kind: VariableType) -> str:
        if self.version == 2:
            return _NAMES_2[kind]
        return "Int64" if kind is VariableType.ENUMERATION else str(kind)

    def _call(self, what: str, function: Any) -> None:
        """A step of the start-up: what an FMU refuses before it has run is what it was given."""
        try:
            function()
        except CohapticError:
            raise
        except Exception as error:  # FMPy's FMICallException
            status = getattr(error, "status", None)
            word = STATUS_NAMES[status] if isinstance(status, int) and 0 <= status < 6 else error
            kind = RunError if word == "fatal" else InputError
            raise kind(
                f"{self.component}: the FMU refused to {what} (status {word}){self._said()}"
            ) from None

    def _said(self) -> str:
        messages = self.messages()
        return f"; it said: {' / '.join(messages)}" if messages else ""


def find_binary(description: FmuDescription) -> Path:
    """The FMU's library for this machine.

    Raises:
        InputError: there is none; says for which platforms there is.
    """
    fmpy: Any = importlib.import_module("fmpy")
    platform = fmpy.platform if description.version == 2 else fmpy.platform_tuple
    binaries = description.folder / "binaries"
    path = binaries / platform / (description.model_identifier + fmpy.sharedLibraryExtension)
    if path.is_file():
        return path
    there = sorted(p.name for p in binaries.iterdir() if p.is_dir()) if binaries.is_dir() else []
    raise InputError(
        f"the FMU {description.path} has no library for {platform}, this machine; it has "
        + (f"{', '.join(there)}" if there else "none at all (source code only?)")
    )


def choose_substeps(description: FmuDescription, clock: Clock, period: int, asked: int) -> int:
    """How many equal steps the FMU takes in one period.

    An FMU that cannot vary its step takes the step that it was made for, as often as it fits.

    Raises:
        InputError: it does not fit; says which rates do.
    """
    fixed = description.fixed_step
    if fixed is None or asked > 1:
        return asked
    whole = period * clock.tick
    ratio = whole / fixed
    if ratio.denominator == 1:
        return ratio.numerator
    nearest = sorted({max(1, int(ratio)), int(ratio) + 1})
    rates = " or ".join(hertz(1 / (count * fixed)) for count in nearest)
    raise InputError(
        f"the FMU {description.path.name} can only step by {float(fixed):g} s, which does not "
        f"divide its period of {float(whole):g} s; give it a rate of {rates}, or say 'substeps'"
    )


def _error_categories(categories: Iterable[str]) -> list[str]:
    words = ("error", "fatal", "warning", "discard")
    return [name for name in categories if any(word in name.lower() for word in words)]


def _show(elements: list[Any]) -> str:
    return repr(elements[0]) if len(elements) == 1 else repr(elements)
