"""A loaded FMU: instantiated, given its parameters, initialised, stepped by the kernel, freed."""

from __future__ import annotations

import ctypes
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from cosim.base.component import Causality, VariableType
from cosim.base.errors import InputError, RunError
from cosim.master.assembly.clock import Clock
from cosim.master.components.interface import size_of
from cosim.master.fmu.binding import (
    FATAL,
    OK,
    WARNING,
    Assignment,
    Binding,
    library_suffix,
    platform_folder,
)
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.fmi2 import Fmi2
from cosim.master.fmu.fmi3 import Fmi3
from cosim.master.fmu.isolation.exchange import Room
from cosim.master.fmu.isolation.isolated import GONE, Isolated
from cosim.master.fmu.library import give_back, take_library
from cosim.master.fmu.log import STATUS_NAMES, Log, Said
from cosim.master.kernel.structures import RestartStruct
from cosim.scenario.build.timebase import hertz

Texts = tuple[int, list[bytes]]
"""A status, and contents."""


class Fmu:
    """One instance of a co-simulation FMU of FMI 2.0 or 3.0.

    ``calling`` is told the name of each function before it is called; the kernel says itself what
    it calls. ``close`` is safe at any time and more than once.
    """

    def __init__(
        self,
        component: str,
        description: FmuDescription,
        *,
        substeps: int,
        is_trusted: bool = False,
        is_isolated: bool = False,
        calling: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.component = component
        self.description = description
        self.version = description.version
        self.substeps = substeps
        self.is_trusted = is_trusted
        """Ours: a reset is known to leave nothing of a run, and no call to change the process."""
        self.is_isolated = is_isolated
        """Whether it lives in a process of its own."""
        self._process: Isolated | None = None
        self._log = Log()
        self._changed: Counter[str] = Counter()
        self._lapses: Counter[str] = Counter()
        self._binding: Binding | None = None
        self._calling = calling
        self._initialised = False
        self._structural = frozenset(
            name
            for name, variable in description.variables.items()
            if variable.causality is Causality.STRUCTURAL_PARAMETER
        )
        self._state: Any = None
        self.library = find_binary(description)
        """The file that all instances of this FMU share."""
        self.is_lost = False
        """Whether a fatal status came back: nothing may be called any more, not even to free it."""

    @property
    def instance(self) -> int:
        """Address of the instance."""
        return self._bound.handle

    @property
    def events(self) -> list[int]:
        """Addresses of the functions of event mode, where it is used."""
        return self._bound.event_addresses() if self.description.events is not None else []

    @property
    def do_step(self) -> int:
        """Address of the step function."""
        return self._bound.do_step_address()

    def accessor(self, kind: VariableType, *, is_set: bool) -> int:
        """Address of the set or get function of a type."""
        return self._bound.accessor_address(kind, is_set=is_set)

    def reference(self, variable: str) -> int:
        """The value reference of a variable."""
        return self.description.references[variable]

    def messages(self) -> list[str]:
        """What the FMU gave as a reason, oldest first, each text once."""
        return self._log.reasons()

    def said(self) -> tuple[Said, ...]:
        """What the FMU logged as a warning or worse, and what it changed outside of itself."""
        if not self._changed and not self._lapses:
            return self._log.said()
        changed = (
            Said("warning", f"it changed {what}, which was put back", count)
            for what, count in self._changed.items()
        )
        lapses = (Said("warning", what, count) for what, count in self._lapses.items())
        return (*self._log.said(), *changed, *lapses)

    def disturbed(self, what: str) -> None:
        """It has changed what belongs to the process."""
        self._changed[what] += 1

    def instantiate(self) -> None:
        """Load the library and create the instance.

        Raises:
            InputError: no library for this platform, or the FMU refuses to be instantiated.
        """
        description = self.description
        self._calling("the loading of its library")
        try:
            self._binding = self._apart() if self.is_isolated else self._here()
        except InputError as error:
            raise InputError(
                f"{self.component}: {description.path.name}: {error.message}"
            ) from None
        missing = self._binding.missing_event_functions() if description.events else []
        if missing:
            raise InputError(
                f"{self.component}: the library of the FMU {description.path.name} has no function "
                f"{' and none '.join(missing)}, though its description says that it has event mode;"
                " 'event_mode: false' does without"
            )
        categories = _error_categories(description.log_categories)
        if not self._binding.instantiate(
            self.component,
            description.token,
            description.folder / "resources",
            log_all=not categories,
            event_mode=description.events is not None,
            early_return=description.events is not None and description.events.may_return,
        ):
            raise InputError(
                f"{self.component}: the FMU {description.path.name} could not be "
                f"instantiated{self._said()}"
            )
        if categories and self._binding.choose_log_categories(categories) == FATAL:
            self._check("choose what is logged", FATAL)  # any other refusal leaves it less to say

    def _here(self) -> Binding:
        library = take_library(self.library, self.version, renew=not self.is_trusted)
        self._log.open()
        bound = Fmi2 if self.version == 2 else Fmi3
        return bound(library, self._log.address, self._calling)

    def _apart(self) -> Binding:
        variables = self.description.variables.values()
        room = Room(len(variables), sum(size_of(variable) for variable in variables))
        self._process = Isolated(self.library, self.version, room, self._calling)
        self._log = self._process.log
        self._process.load()
        return self._process

    def manner_of_ending(self) -> str:
        """How the process that it has for itself has ended."""
        return "ended" if self._process is None else self._process.manner()

    def renew(self, *, failed: bool) -> None:
        """Be as after ``instantiate`` again, for another run; ``failed`` as for ``close``.

        Our own FMUs are reset. What others make of a reset is not known, so they are freed and made
        anew.

        Raises:
            InputError: as ``instantiate``.
        """
        trusted = self.is_trusted and not self.is_lost
        if trusted and self._bound.reset() in {OK, WARNING}:
            self._log.forget()
        else:
            self.close(failed=failed)
            self._log.forget()
            self.is_lost = False
            self.instantiate()
        self._initialised = False

    def set_values(self, values: Mapping[str, list[Any]]) -> None:
        """Set parameters or start values before initialisation; ``configure`` comes first.

        Raises:
            InputError: the FMU refuses one.
        """
        self._set_each({n: e for n, e in values.items() if n not in self._structural})

    def _set_each(self, values: Mapping[str, list[Any]]) -> None:
        for name, elements in values.items():
            kind = self.description.variables[name].type
            try:
                status = self._bound.set_values(kind, self.reference(name), elements)
            except (ValueError, TypeError, OverflowError, ctypes.ArgumentError) as error:
                raise InputError(
                    f"{self.component}: {name} = {_show(elements)} does not fit its type, {kind}"
                ) from error
            if status not in {OK, WARNING}:
                self.judge(status)
                raise InputError(
                    f"{self.component}: the FMU refuses {name} = {_show(elements)}{self._said()}"
                )

    @property
    def can_restart(self) -> bool:
        """Whether another run may be had from a reset, with calls from outside of this object."""
        bound = self._binding
        return (
            self.is_trusted
            and not self.is_lost
            and not self._structural
            and self.description.events is None
            and self._initialised
            and isinstance(bound, Fmi2 | Fmi3)
            and bound.beginnings().reset != 0
        )

    def restart(self) -> RestartStruct:
        """Addresses of all that a restart takes, where ``can_restart``; it sets no values yet."""
        bound = cast("Fmi2 | Fmi3", self._bound)
        begin = bound.beginnings()
        return RestartStruct(
            instance=bound.handle,
            version=self.version,
            reset=begin.reset,
            set_up=begin.set_up,
            enter=begin.enter,
            leave=begin.leave,
            log=self._log.address,
        )

    def assignments(self, values: Mapping[str, list[Any]]) -> list[tuple[int, Assignment]]:
        """The functions and their arguments that set all values, one for each type.

        Raises:
            ValueError, TypeError, OverflowError, ctypes.ArgumentError: one does not fit its type.
        """
        bound = cast("Fmi2 | Fmi3", self._bound)
        of_type: dict[VariableType, list[str]] = {}
        for name in values:
            of_type.setdefault(self.description.variables[name].type, []).append(name)
        found: list[tuple[int, Assignment]] = []
        for kind, names in of_type.items():
            references = [self.reference(name) for name in names]
            elements = [element for name in names for element in values[name]]
            ready = bound.assignment(kind, references, elements)
            found.append((bound.address(ready.function), ready))
        return found

    def left_initialisation(self, status: int) -> None:
        """Take note of what leaving initialisation mode returned.

        Raises:
            InputError: the FMU refuses to: its parameters and inputs do not go together.
            RunError: it failed for good.
        """
        self._check("leave initialisation mode", status)
        self._initialised = True

    def get_texts(self, kind: VariableType, names: Sequence[str], count: int) -> Texts:
        """The status, and the elements of String or Binary variables of one type.

        No text at all (NULL) is taken as an empty one, and what is not UTF-8 in a String is
        replaced by the sign for that; either is among what the FMU ``said``.

        Raises:
            ValueError: one is longer than what is carried.
        """
        references = [self.reference(name) for name in names]
        status, found = self._bound.get_texts(kind, references, count)
        self._calling("")
        contents = [self._mended(content, names, kind) for content in found]
        return status, contents

    def set_texts(self, kind: VariableType, names: Sequence[str], contents: list[bytes]) -> int:
        """The status of setting all elements of String or Binary variables of one type."""
        references = [self.reference(name) for name in names]
        status = self._bound.set_texts(kind, references, contents)
        self._calling("")
        return status

    def _mended(self, content: bytes | None, names: Sequence[str], kind: VariableType) -> bytes:
        which = names[0] if len(names) == 1 else f"one of {', '.join(names)}"
        if content is None:
            self._lapses[f"it put out no {kind} at all (NULL) as {which}"] += 1
            return b""
        if kind is VariableType.STRING:
            mended = content.decode(errors="replace").encode()
            if mended != content:
                self._lapses[f"it put out a String that is not UTF-8 as {which}"] += 1
            return mended
        return content

    def configure(self, values: Mapping[str, list[Any]]) -> None:
        """Set structural parameters in FMI 3's configuration mode.

        Raises:
            InputError: the FMU refuses one, or all of them together.
            RunError: it failed for good.
        """
        if not self._structural:
            return
        structural = {n: e for n, e in values.items() if n in self._structural}
        if not structural:
            return
        self._check("enter configuration mode", self._bound.enter_configuration())
        self._set_each(structural)
        self._check("leave configuration mode", self._bound.exit_configuration())

    def enter_initialisation(self, start_time: float, stop_time: float) -> None:
        """Set up the experiment and enter initialisation mode; times in seconds.

        Raises:
            InputError: the FMU refuses to.
            RunError: it failed for good.
        """
        times = (start_time, stop_time)
        self._check("set up the experiment", self._bound.set_up_experiment(*times))
        self._check("enter initialisation mode", self._bound.enter_initialisation(*times))

    def exit_initialisation(self) -> None:
        """Leave initialisation mode, ready to step.

        Raises:
            InputError: the FMU refuses to: its parameters and inputs do not go together.
            RunError: it failed for good.
        """
        self.left_initialisation(self._bound.exit_initialisation())

    def save_state(self) -> bytes:
        """The whole state between two steps, where ``saves_state`` says that there is one.

        Raises:
            RunError: the FMU cannot give it.
        """
        status, content = self._state_bound().save_state()
        self._check_state("save its state", status)
        return content

    def load_state(self, content: bytes) -> None:
        """Go on from what ``save_state`` returned; initialisation is over.

        Raises:
            RunError: the FMU refuses it; what state it has then is not known.
        """
        self._check_state("restore its state", self._state_bound().load_state(content))

    def keep_state(self) -> None:
        """Remember the whole state between two steps, for ``return_to_state``.

        Raises:
            RunError: the FMU cannot give it.
        """
        self._drop_state()
        status, state = self._state_bound().keep_state()
        self._check_state("save its state", status)
        self._state = state

    def return_to_state(self) -> None:
        """Go back to what was kept.

        Raises:
            RunError: the FMU refuses it; what state it has then is not known.
        """
        assert self._state is not None
        self._check_state("restore its state", self._bound.put_state(self._state))
        self._log.forget()

    def _drop_state(self) -> None:
        state, self._state = self._state, None
        if state is not None and not self.is_lost:
            self._bound.drop_state(state)  # whatever it returns: it is not asked for any more

    def _state_bound(self) -> Binding:
        missing = self._bound.missing_state_functions()
        if missing:
            raise RunError(
                f"{self.component}: the FMU {self.description.path.name} says that its state can "
                f"be saved, but its library has no function {' and none '.join(missing)}"
            )
        return self._bound

    def _check_state(self, what: str, status: int) -> None:
        if status not in {OK, WARNING}:
            word = STATUS_NAMES[status] if 0 <= status < len(STATUS_NAMES) else str(status)
            raise RunError(f"{self.component}: the FMU cannot {what} (status {word}){self._said()}")

    def asks_to_end(self) -> bool:
        """After a step that was discarded: whether it was because the model has come to its end.

        FMI 3 says so with the step itself; FMI 2 is asked for it (section 4.2.1, fmi2Terminated).
        """
        return self._bound.asks_to_end()

    def judge(self, status: int) -> None:
        """Take note of what a call returned that was not well."""
        self.is_lost = self.is_lost or status in {FATAL, GONE}

    def close(self, *, failed: bool = False) -> None:
        """Terminate and free; nothing at all after a fatal status (FMI 2.0.4 section 2.1.3).

        ``failed``: an error status was met, by this instance or fatally by another one of the same
        library, so only freeing is allowed.
        """
        if self._binding is not None:
            self._drop_state()
        binding, self._binding = self._binding, None
        process, self._process = self._process, None
        try:
            if binding is not None and binding.handle and not self.is_lost:
                if self._initialised and not failed:
                    binding.terminate()  # whatever it returns: closing must reach every component
                binding.free()
        finally:
            if process is not None:
                process.end()
            elif binding is not None:
                give_back(self.library, self.version, lost=self.is_lost)
                self._log.close()

    @property
    def _bound(self) -> Binding:
        if self._binding is None:
            raise RunError(f"{self.component}: the FMU is not loaded")
        return self._binding

    def _check(self, what: str, status: int) -> None:
        """A step of the start-up: what an FMU refuses before it has run is what it was given."""
        if status in {OK, WARNING}:
            return
        self.judge(status)
        word = STATUS_NAMES[status] if 0 <= status < len(STATUS_NAMES) else str(status)
        kind = RunError if word == "fatal" else InputError
        raise kind(f"{self.component}: the FMU refused to {what} (status {word}){self._said()}")

    def _said(self) -> str:
        messages = self.messages()
        return f"; it said: {' / '.join(messages)}" if messages else ""


def find_binary(description: FmuDescription) -> Path:
    """The FMU's library for this machine.

    Raises:
        InputError: there is none; says for which platforms there is.
    """
    platform = platform_folder(description.version)
    binaries = description.folder / "binaries"
    path = binaries / platform / (description.model_identifier + library_suffix())
    if path.is_file():
        return path
    if path.is_dir():
        raise InputError(
            f"{path.relative_to(description.folder)} of the FMU {description.path} is "
            "a folder, not a library"
        )
    if (binaries / platform).is_dir():
        others = sorted(p.name for p in (binaries / platform).glob(f"*{library_suffix()}"))
        raise InputError(
            f"the library of the FMU {description.path} has to be called {path.name}, as its "
            f"modelIdentifier; in {platform} "
            + (f"there is {', '.join(others)}" if others else "there is no library at all")
        )
    there = sorted(p.name for p in binaries.iterdir() if p.is_dir()) if binaries.is_dir() else []
    raise InputError(
        f"the FMU {description.path} has no library for {platform}, this machine; it has "
        + (f"{', '.join(there)}" if there else "none at all (source code only?)")
    )


def choose_substeps(
    description: FmuDescription, clock: Clock, period: int, asked: int
) -> tuple[int, str]:
    """How many equal steps the FMU takes in one period, and a note where it prefers others.

    An FMU that cannot vary its step takes the step that it was made for, as often as it fits;
    where that does not fit, steps of another length, which are legal as long as all are equal
    (FMI 2.0.4 section 4.3.1, ``canHandleVariableCommunicationStepSize``).
    """
    fixed = description.fixed_step
    if fixed is None or asked > 1:
        return asked, ""
    whole = period * clock.tick
    ratio = whole / fixed
    if ratio.denominator == 1:
        return ratio.numerator, ""
    nearest = sorted({max(1, int(ratio)), int(ratio) + 1})
    rates = " or ".join(hertz(1 / (count * fixed)) for count in nearest)
    return asked, (
        f"the FMU {description.path.name} was made for steps of {float(fixed):g} s, which do not "
        f"divide its period; all its steps are {float(whole):g} s long (a rate of {rates} would "
        "give it its own)"
    )


def _error_categories(categories: Iterable[str]) -> list[str]:
    words = ("error", "fatal", "warning", "discard")
    return [name for name in categories if any(word in name.lower() for word in words)]


def _show(elements: list[Any]) -> str:
    return repr(elements[0]) if len(elements) == 1 else repr(elements)
