"""The whole state of an FMU between two steps: as bytes, or kept by itself."""

from __future__ import annotations

from typing import Any

from cosim.base.errors import RunError
from cosim.master.fmu.binding import Binding
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.loaded.conduct import Conduct
from cosim.master.fmu.loaded.residence import Residence


class States:
    """Those of one instance, where ``saves_state`` of its description says that there are any."""

    def __init__(
        self,
        component: str,
        description: FmuDescription,
        residence: Residence,
        conduct: Conduct,
    ) -> None:
        self._component = component
        self._file = description.path.name
        self._residence = residence
        self._conduct = conduct
        self._kept: Any = None

    def save(self) -> bytes:
        """The state as bytes.

        Raises:
            RunError: the FMU cannot give it.
        """
        status, content = self._bound().save_state()
        self._conduct.check_state("save its state", status)
        return content

    def load(self, content: bytes) -> None:
        """Go on from what ``save`` returned; initialisation is over.

        Raises:
            RunError: the FMU refuses it; what state it has then is not known.
        """
        self._conduct.check_state("restore its state", self._bound().load_state(content))

    def keep(self) -> None:
        """Remember the state, for ``go_back``.

        Raises:
            RunError: the FMU cannot give it.
        """
        self.drop()
        status, state = self._bound().keep_state()
        self._conduct.check_state("save its state", status)
        self._kept = state

    def go_back(self) -> None:
        """Be where the state was kept.

        Raises:
            RunError: the FMU refuses it; what state it has then is not known.
        """
        assert self._kept is not None
        self._conduct.check_state("restore its state", self._residence.bound.put_state(self._kept))
        self._residence.log.forget()

    def drop(self) -> None:
        """Give back what was kept, if anything was and the FMU may be called at all."""
        state, self._kept = self._kept, None
        if state is not None and not self._conduct.is_lost:
            self._residence.bound.drop_state(state)  # whatever it returns: it is not needed again

    def _bound(self) -> Binding:
        bound = self._residence.bound
        missing = bound.missing_state_functions()
        if missing:
            raise RunError(
                f"{self._component}: the FMU {self._file} says that its state can "
                f"be saved, but its library has no function {' and none '.join(missing)}"
            )
        return bound
