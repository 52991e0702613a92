"""A loaded FMU: instantiated, given its parameters, initialised, stepped by the kernel, freed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import cast

from cosim.base.component import VariableType
from cosim.base.errors import InputError, RunError
from cosim.master.fmu.binding import FATAL, OK, WARNING, Binding, InstanceWanted
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.fmi2 import Fmi2
from cosim.master.fmu.fmi3 import Fmi3
from cosim.master.fmu.isolation.isolated import ProcessEnded
from cosim.master.fmu.loaded.conduct import AFTER_FATAL, Conduct
from cosim.master.fmu.loaded.residence import Residence
from cosim.master.fmu.loaded.states import States
from cosim.master.fmu.loaded.texts import TextCalls
from cosim.master.fmu.loaded.values import GivenValues
from cosim.master.fmu.log import Log, Said
from cosim.master.kernel.fmu_structures import RestartStruct


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
        log: Log | None = None,
        calling: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.component = component
        self.description = description
        self.version = description.version
        self.substeps = substeps
        self.is_trusted = is_trusted
        """Ours: a reset is known to leave nothing of a run, and no call to change the process."""
        self._residence = Residence(
            component,
            description,
            is_trusted=is_trusted,
            is_isolated=is_isolated,
            log=log or Log(),
            calling=calling,
        )
        self._conduct = Conduct(component, self._residence)
        self._texts = TextCalls(description, self._residence, self._conduct)
        self.states = States(component, description, self._residence, self._conduct)
        """Its state between two steps, saved and put back."""
        self.values = GivenValues(component, description, self._residence, self._conduct)
        """What it is given before it runs."""
        self._initialised = False

    @property
    def is_isolated(self) -> bool:
        """Whether it lives in a process of its own."""
        return self._residence.is_isolated

    @property
    def library(self) -> Path:
        """The file that all instances of this FMU share."""
        return self._residence.library

    @property
    def is_lost(self) -> bool:
        """Whether a fatal status came back: nothing may be called any more, not even to free it."""
        return self._conduct.is_lost

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
        return self._conduct.messages()

    def reason(self) -> str:
        """What it gave as a reason, as the end of a sentence; or nothing."""
        return self._conduct.reasons()

    def said(self) -> tuple[Said, ...]:
        """What the FMU logged as a warning or worse, and what it changed outside of itself."""
        return self._conduct.said()

    def disturbed(self, what: str) -> None:
        """It has changed what belongs to the process."""
        self._conduct.disturbed(what)

    @property
    def is_gone(self) -> bool:
        """Whether the process that it has for itself was found to have ended."""
        return self._residence.is_gone

    def judge(self, status: int) -> None:
        """Take note of what a call returned."""
        self._conduct.judge(status)

    def instantiate(self) -> None:
        """Load the library and create the instance.

        Raises:
            InputError: no library for this platform, or the FMU refuses to be instantiated.
        """
        description = self.description
        try:
            binding = self._residence.load()
        except InputError as error:
            raise InputError(
                f"{self.component}: {description.path.name}: {error.message}"
            ) from None
        missing = binding.missing_event_functions() if description.events else []
        if missing:
            raise InputError(
                f"{self.component}: the library of the FMU {description.path.name} has no function "
                f"{' and none '.join(missing)}, though its description says that it has event mode;"
                " 'event_mode: false' does without"
            )
        categories = _error_categories(description.log_categories)
        events = description.events
        wanted = InstanceWanted(
            name=self.component,
            token=description.token,
            resources=description.folder / "resources",
            log_all=not categories,
            event_mode=events is not None,
            early_return=events is not None and events.may_return,
        )
        if not binding.instantiate(wanted):
            raise InputError(
                f"{self.component}: the FMU {description.path.name} could not be "
                f"instantiated{self._conduct.reasons()}"
            )
        if categories and binding.choose_log_categories(categories) == FATAL:
            # Any other refusal leaves it less to say.
            self._conduct.check_start("choose what is logged", FATAL)

    def manner_of_ending(self) -> str:
        """How the process that it has for itself has ended."""
        return self._residence.manner_of_ending()

    def renew(self, *, failed: bool) -> None:
        """Be as after ``instantiate`` again, for another run; ``failed`` as for ``close``.

        Our own FMUs are reset. What others make of a reset is not known, so they are freed and made
        anew.

        Raises:
            InputError: as ``instantiate``.
            RunError: it is lost.
        """
        status = self._bound.reset() if self.is_trusted and not self.is_lost else None
        is_reset = status in {OK, WARNING}
        if not is_reset:
            self._conduct.judge(OK if status is None else status)
            self.close(failed=failed)
            if self.is_lost:
                raise RunError(f"{self.component}: {AFTER_FATAL}.")
        self._residence.log.forget()
        self._conduct.forget()
        if not is_reset:
            self.instantiate()
        self._initialised = False

    @property
    def can_restart(self) -> bool:
        """Whether another run may be had from a reset, with calls from outside of this object."""
        bound = self._residence.binding
        return (
            self.is_trusted
            and not self.is_lost
            and not self.values.are_structural
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
            log=self._residence.log.address,
        )

    def entered_initialisation(self) -> None:
        """Take note that it is set up once more: until it leaves, there is nothing to terminate."""
        self._initialised = False

    def left_initialisation(self, status: int) -> None:
        """Take note of what leaving initialisation mode returned.

        Raises:
            InputError: the FMU refuses to: its parameters and inputs do not go together.
            RunError: it failed for good.
        """
        self._conduct.check_start("leave initialisation mode", status)
        self._initialised = True

    def get_texts(
        self, kind: VariableType, names: Sequence[str], count: int
    ) -> tuple[int, list[bytes]]:
        """The status, and the elements of String or Binary variables of one type.

        Raises:
            ValueError: one is longer than what is carried.
        """
        return self._texts.get(kind, names, count)

    def set_texts(self, kind: VariableType, names: Sequence[str], contents: list[bytes]) -> int:
        """The status of setting all elements of String or Binary variables of one type."""
        return self._texts.set(kind, names, contents)

    def enter_initialisation(self, start_time: float, stop_time: float) -> None:
        """Set up the experiment and enter initialisation mode; times in seconds.

        Raises:
            InputError: the FMU refuses to.
            RunError: it failed for good.
        """
        times = (start_time, stop_time)
        self._conduct.check_start("set up the experiment", self._bound.set_up_experiment(*times))
        self._conduct.check_start(
            "enter initialisation mode", self._bound.enter_initialisation(*times)
        )
        events = self.description.events
        if events is not None and (chosen := events.chosen_intervals()):
            references = [self.reference(name) for name in chosen]
            status = self._bound.set_intervals(references, list(chosen.values()))
            self._conduct.check_start("take the intervals of its clocks", status)

    def exit_initialisation(self) -> None:
        """Leave initialisation mode, ready to step.

        Raises:
            InputError: the FMU refuses to: its parameters and inputs do not go together.
            RunError: it failed for good.
        """
        self.left_initialisation(self._bound.exit_initialisation())

    def asks_to_end(self) -> bool:
        """After a step that was discarded: whether it was because the model has come to its end.

        FMI 3 says so with the step itself; FMI 2 is asked for it (section 4.2.1, fmi2Terminated).
        """
        status, asks = self._bound.asks_to_end()
        self._residence.calling("")
        self._conduct.judge(status)
        return asks

    def close(self, *, failed: bool = False) -> int:
        """Terminate and free; nothing at all after a fatal status (FMI 2.0.4 section 2.1.3).

        ``failed``: an error status was met, by this instance or fatally by another one of the same
        library, so only freeing is allowed. What terminating returned; it is closed all the same.
        """
        try:
            return self._take_leave(failed=failed)
        finally:
            with self._residence.leaving(is_lost=self.is_lost) as binding:
                if binding is not None and binding.handle and not self.is_lost:
                    binding.free()

    def _take_leave(self, *, failed: bool) -> int:
        """Every call before the last one; what terminating returned, where it was called."""
        binding = self._residence.binding
        if binding is None or not binding.handle or self.is_lost:
            return OK
        try:
            self.states.drop_all()
            if not self._initialised or failed or self._conduct.has_failed:
                return OK
            status = binding.terminate()
        except ProcessEnded:
            self._conduct.judge(OK)
            raise
        self._conduct.judge(status)
        return status

    @property
    def _bound(self) -> Binding:
        return self._residence.bound


def _error_categories(categories: Iterable[str]) -> list[str]:
    words = ("error", "fatal", "warning", "discard")
    return [name for name in categories if any(word in name.lower() for word in words)]
