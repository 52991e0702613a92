"""The whole state of an FMU between two steps: as bytes, or kept by itself."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import c_void_p
from functools import partial
from typing import Any

from cosim.base.errors import RunError
from cosim.master.fmu.binding import Binding
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.loaded.conduct import AFTER_FATAL, Conduct
from cosim.master.fmu.loaded.residence import Residence
from cosim.master.fmu.state import Look, StateError


class States:
    """Those of one instance, where ``saves_state`` of its description says that there are any.

    ``when`` is what an error says of the time: empty, or `` at tick 3 (3 s)``.
    """

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
        self._complete: Binding | None = None
        """The binding that was found to have every function."""
        self._looked = Look(c_void_p())
        self._kept: Any = None
        self.keeper: object = None
        """Whose the kept state is; another who keeps one takes its place."""

    def save(self, when: str = "") -> bytes:
        """The state as bytes.

        Raises:
            RunError: the FMU cannot give it.
        """
        with self._calls(when) as bound:
            status, content = bound.save_state()
        self._conduct.check_state("save its state", status, when)
        return content

    def look(self, when: str = "") -> Any:
        """The state as bytes, which the next look overwrites: for many of them.

        Raises:
            RunError: the FMU cannot give it.
        """
        with self._calls(when) as bound:
            status = bound.look_at_state(self._looked)
        self._conduct.check_state("save its state", status, when)
        return self._looked.content

    def load(self, content: bytes, when: str = "") -> None:
        """Go on from what ``save`` returned; initialisation is over.

        Raises:
            RunError: the FMU refuses it; what state it has then is not known.
        """
        with self._calls(when) as bound:
            status = bound.load_state(content)
        self._conduct.check_state("restore its state", status, when)

    def keep(self, when: str = "", keeper: object = None) -> None:
        """Remember the state, for ``go_back``; ``keeper`` says whose it is.

        Raises:
            RunError: the FMU cannot give it.
        """
        self.drop()
        with self._calls(when) as bound:
            status, state = bound.keep_state()
        self._conduct.check_state("save its state", status, when)
        self._kept = state
        self.keeper = keeper

    def go_back(self, when: str = "") -> None:
        """Be where the state was kept.

        Raises:
            RunError: the FMU refuses it; what state it has then is not known.
        """
        assert self._kept is not None
        with self._calls(when) as bound:
            status = bound.put_state(self._kept)
        self._conduct.check_state("restore its state", status, when)
        self._residence.log.forget()

    def drop(self) -> None:
        """Give back what was kept, if anything was and the FMU may be called at all."""
        state, self._kept, self.keeper = self._kept, None, None
        self._give_back(state)

    def drop_all(self) -> None:
        """The same, and what was looked at: for the end."""
        self.drop()
        looked, self._looked = self._looked.state, Look(c_void_p())
        self._give_back(looked if looked else None)

    def _give_back(self, state: Any) -> None:
        if state is not None and not self._conduct.is_lost:
            with self._calls() as bound:
                # It is not needed again, so that nothing but what may be called hangs on this.
                self._conduct.judge(bound.drop_state(state))

    def _calls(self, when: str = "") -> _Calls:
        """What is called by name; afterwards nothing of it is going on."""
        if self._conduct.is_lost:
            raise RunError(f"{self._component}: {AFTER_FATAL}.")
        bound = self._residence.bound
        missing = () if bound is self._complete else bound.missing_state_functions()
        if missing:
            raise RunError(
                f"{self._component}: the FMU {self._file} says that its state can "
                f"be saved, but its library has no function {' and none '.join(missing)}{when}"
            )
        self._complete = bound
        return _Calls(bound, self._residence, partial(self._refused, when))

    def _refused(self, when: str, error: StateError) -> RunError:
        return RunError(f"{self._component}: {error}{when}{self._conduct.reasons()}")


class _Calls:
    """Inside, the binding; many thousands a second, which a generator would slow down."""

    __slots__ = ("_binding", "_refused", "_residence")

    def __init__(
        self, binding: Binding, residence: Residence, refused: Callable[[StateError], RunError]
    ) -> None:
        self._binding, self._residence, self._refused = binding, residence, refused

    def __enter__(self) -> Binding:
        return self._binding

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if isinstance(error, StateError):
            raise self._refused(error) from None
        if error is None:
            self._residence.calling("")
