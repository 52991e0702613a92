"""Where an FMU's library lives: in this process, or in one of its own."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager

from cosim.base.errors import RunError
from cosim.master.components.interface import size_of
from cosim.master.fmu.binding import Binding
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.fmi2 import Fmi2
from cosim.master.fmu.fmi3 import Fmi3
from cosim.master.fmu.isolation.exchange import Room
from cosim.master.fmu.isolation.isolated import Isolated
from cosim.master.fmu.library import give_back, take_library
from cosim.master.fmu.loaded.binary import find_binary
from cosim.master.fmu.log import Log


class Residence:
    """Of one instance; it may be left, and entered again.

    ``calling`` is told the name of each function before it is called.
    """

    def __init__(
        self,
        component: str,
        description: FmuDescription,
        *,
        is_trusted: bool,
        is_isolated: bool,
        log: Log,
        calling: Callable[[str], None],
    ) -> None:
        self.is_isolated = is_isolated
        """Whether it lives in a process of its own."""
        self.library = find_binary(description)
        """The file that all instances of this FMU share."""
        self.log = log
        self.binding: Binding | None = None
        """What calls its functions, while it is loaded."""
        self.process: Isolated | None = None
        self.calling = calling
        self._component = component
        self._description = description
        self._is_trusted = is_trusted

    @property
    def bound(self) -> Binding:
        """What calls its functions.

        Raises:
            RunError: it is not loaded.
        """
        if self.binding is None:
            raise RunError(f"{self._component}: the FMU is not loaded")
        return self.binding

    @property
    def is_gone(self) -> bool:
        """Whether the process that it has for itself was found to have ended."""
        return self.process is not None and self.process.is_gone

    def load(self) -> Binding:
        """Load the library.

        Raises:
            InputError: it cannot be loaded, or lacks functions.
        """
        self.calling("the loading of its library")
        self.binding = self._apart() if self.is_isolated else self._here()
        return self.binding

    def manner_of_ending(self) -> str:
        """How the process that it has for itself has ended."""
        return "ended" if self.process is None else self.process.manner()

    @contextmanager
    def leaving(self, *, is_lost: bool) -> Generator[Binding | None]:
        """The last calls; then the process is ended, or the library given back."""
        binding, self.binding = self.binding, None
        process, self.process = self.process, None
        try:
            yield binding
        finally:
            if process is not None:
                process.end()
            elif binding is not None:
                give_back(self.library, self._description.version, lost=is_lost)
                self.log.close()

    def _here(self) -> Binding:
        version = self._description.version
        library = take_library(self.library, version, renew=not self._is_trusted)
        self.log.open()
        return (Fmi2 if version == 2 else Fmi3)(library, self.log.address, self.calling)

    def _apart(self) -> Binding:
        variables = self._description.variables.values()
        room = Room(len(variables), sum(size_of(variable) for variable in variables))
        self.process = Isolated(self.library, self._description.version, room, self.calling)
        self.log = self.process.log
        self.process.load()
        return self.process
