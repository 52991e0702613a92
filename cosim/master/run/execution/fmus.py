"""The FMUs of a simulation: made, initialised, restarted from run to run, freed.

The process is protected from those that are not ours: what they change of it is put back, and the
end of the process that one has for itself becomes a sentence.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial

from cosim.base.errors import RunError
from cosim.master.assembly.assemble import Assembly
from cosim.master.fmu.binding import OK, WARNING
from cosim.master.fmu.instance import Fmu
from cosim.master.fmu.isolation.isolated import GONE, ProcessEnded
from cosim.master.fmu.loaded.conduct import AFTER_FATAL, status_word
from cosim.master.fmu.log import Said
from cosim.master.fmu.refusal import placed_refusal
from cosim.master.fmu.surroundings import Surroundings
from cosim.master.run.leaving import told_of
from cosim.master.run.restart import Restart, Times
from cosim.master.run.whereabouts import Whereabouts

_UNGUARDED = nullcontext()

Told = Callable[[str, str], None]
"""Told a component's name, and what is about to be done with it."""


class RunningFmus:
    """All FMUs of one simulation; ``assembly`` is what they run, another one after ``renew``."""

    def __init__(self, assembly: Assembly, whereabouts: Whereabouts) -> None:
        self.assembly = assembly
        self.all: dict[str, Fmu] = {}
        """By component; empty before the first run."""
        self.closing_error = ""
        """The sentence of one that failed, or whose process ended, when it was closed."""
        self._whereabouts = whereabouts
        self._failed: set[str] = set()
        self._restart: Restart | None = None
        self._is_restarted = False
        self._kept_times: tuple[int, Times] | None = None
        self._are_own: bool | None = None
        """Whether none of them needs to be guarded; ``None`` before that was asked."""

    def refuse_lost(self) -> None:
        """Whether another run may be had.

        Raises:
            RunError: an FMU was lost for good.
        """
        for name, fmu in self.all.items():
            if fmu.is_lost:
                raise RunError(f"{name}: {AFTER_FATAL}.")

    def prepare(self, end: int, told: Told) -> bool:
        """Have all FMUs, with their values, for a run to tick ``end``.

        Whether they are those of the run before, restarted: then all are in initialisation mode.

        Raises:
            InputError: one cannot be loaded, or refuses its values.
            RunError: one failed for good, or when it was freed after the run before.
        """
        times = self._times(end)
        self._is_restarted = self._begin_again(times)
        if not self._is_restarted:
            self._create(told)
        return self._is_restarted

    def enter_initialisation(self, end: int, told: Told) -> None:
        """Enter initialisation mode, where ``prepare`` has not.

        Raises:
            InputError: one refuses to.
        """
        times = self._times(end)
        for name, fmu in self.all.items() if not self._is_restarted else ():
            told(name, "entering initialisation mode")
            with placed_refusal(self.assembly.scenario, name), self.guarding(fmu):
                fmu.enter_initialisation(*times[name])

    def leave_initialisation(self, begin_events: Callable[[str, int], None], told: Told) -> None:
        """Leave initialisation mode; ``begin_events`` is called with a component before and after.

        Raises:
            InputError: one refuses to: its parameters and inputs do not go together.
            RunError: one failed for good.
        """
        if self._restart is not None and self._is_restarted:
            self._restart.leave(self.assembly.scenario)
            return
        for name, fmu in self.all.items():
            told(name, "leaving initialisation mode")
            with placed_refusal(self.assembly.scenario, name), self.guarding(fmu):
                self._whereabouts.clear()
                begin_events(name, 0)
                fmu.exit_initialisation()
                self._whereabouts.clear()
                begin_events(name, 1)

    def fail(self, component: str) -> None:
        """Take note that an error was met in a component."""
        self._failed.add(component)

    def said(self) -> dict[str, tuple[Said, ...]]:
        """What FMUs said that was not well, by component."""
        return {name: said for name, fmu in self.all.items() if (said := fmu.said())}

    def close(self) -> None:
        """Free every FMU; may be called more than once."""
        self._give_up_restart()
        self.closing_error = self._let_go(list(self.all)) or self.closing_error

    def finish(self) -> str:
        """Terminate and free those that are not ours: another run has them anew.

        All that share a library are gone before it is loaded again. The first sentence about one
        that is not well, or nothing.
        """
        if self._are_own:
            return ""
        return self._let_go([name for name, fmu in self.all.items() if not fmu.is_trusted])

    @property
    def guarded(self) -> AbstractContextManager[None]:
        """``guarding`` all of them."""
        if self._are_own is None:
            self._are_own = _are_own(self.all.values())
        return _UNGUARDED if self._are_own else self._guard(*self.all.values())

    def guarding(self, *fmus: Fmu) -> AbstractContextManager[None]:
        """Put back what foreign FMUs, one of these, change of what belongs to the process.

        Raises, inside:
            RunError: the process that one of them has for itself has ended.
        """
        return _UNGUARDED if _are_own(fmus) else self._guard(*fmus)

    @contextmanager
    def _guard(self, *fmus: Fmu) -> Generator[None]:
        foreign = [fmu for fmu in fmus if not fmu.is_trusted]
        before = Surroundings() if foreign else None
        is_told = bool(foreign) and not self._whereabouts.is_watched
        try:
            with told_of(self._left) if is_told else _UNGUARDED:
                yield
        except ProcessEnded as ended:
            component, doing = self._whereabouts.sentence(self.assembly.scenario)
            self.all[component].judge(GONE)
            reason = self.all[component].reason()
            raise RunError(f"{component} {ended.manner} {doing}{reason}") from None
        finally:
            self._whereabouts.clear()
            for what in before.put_back() if before is not None else ():
                for fmu in foreign:
                    fmu.disturbed(what if len(foreign) == 1 else f"{what} (or another FMU did)")

    def _left(self) -> str:
        """The sentence of a process that is ended by ``exit`` inside of a run."""
        scenario = self.assembly.scenario
        component, doing = self._whereabouts.sentence(scenario)
        reason = self._whereabouts.log(component, scenario).reason() if component else ""
        return (
            f"{component or 'the run'} ended this process by exit() {doing}{reason}; its status "
            "is 1. With 'isolate: process' such an FMU ends a process of its own."
        )

    def _times(self, end: int) -> Times:
        """When the run of each FMU begins and ends (s)."""
        if self._kept_times is None or self._kept_times[0] != end:
            parts, clock = self.assembly.parts, self.assembly.clock
            begin = clock.seconds(0)
            # The end of its last step may lie beyond the run's.
            ends = {
                period: clock.seconds(-(-end // period) * period)
                for period in {part.period for part in parts.values()}
            }
            fmus = (name for name, each in self.assembly.participants.items() if each.fmu)
            self._kept_times = end, {name: (begin, ends[parts[name].period]) for name in fmus}
        return self._kept_times[1]

    def _begin_again(self, times: Times) -> bool:
        """Restart the FMUs of the run before; ``False`` where that cannot be."""
        if self._restart is None:
            if self._failed or not self.all or not all(f.can_restart for f in self.all.values()):
                return False
            self._restart = Restart(self.all)
        if not self._failed and self._restart.begin(self.assembly.participants, times):
            return True
        self._give_up_restart()
        return False

    def _give_up_restart(self) -> None:
        if self._restart is not None:
            self._restart.abandon()
            self._restart = None

    def _let_go(self, names: Iterable[str]) -> str:
        """Free these; the first sentence about one that is not well, or nothing."""
        with self._whereabouts.aside():
            return next(iter([said for said in self._let_each_go(names) if said]), "")

    def _let_each_go(self, names: Iterable[str]) -> Generator[str]:
        here = [fmu for fmu in self.all.values() if not fmu.is_isolated]
        lost = {fmu.library for fmu in here if fmu.is_lost}
        for name in names:
            fmu = self.all[name]
            is_here = not fmu.is_isolated
            failed = name in self._failed or (is_here and fmu.library in lost)
            try:
                with self.guarding(fmu):
                    status = fmu.close(failed=failed)
            except RunError as error:
                yield str(error)
                continue
            if status not in {OK, WARNING}:
                when = self._whereabouts.when(self.assembly.scenario)
                yield (
                    f"{name} returned status '{status_word(status)}' from "
                    f"fmi{fmu.version}Terminate {when}{fmu.reason()}"
                )
            if is_here and fmu.is_lost:
                lost.add(fmu.library)

    def _create(self, told: Told) -> None:
        self.closing_error = ""
        if sentence := self.finish():
            raise RunError(sentence)
        scenario, self._are_own = self.assembly.scenario, None
        for name, participant in self.assembly.participants.items():
            if participant.fmu is None:
                continue
            is_new = name not in self.all
            if is_new:
                self.all[name] = Fmu(
                    name,
                    participant.fmu,
                    substeps=participant.substeps,
                    is_trusted=scenario.components[name].is_bundled,
                    is_isolated=participant.is_isolated,
                    log=self._whereabouts.log(name, scenario),
                    calling=partial(self._whereabouts.note, name),
                )
            fmu = self.all[name]
            told(name, "being instantiated and given its values")
            with placed_refusal(scenario, name), self.guarding(fmu):
                if is_new:
                    fmu.instantiate()
                else:
                    fmu.renew(failed=name in self._failed)
                fmu.values.configure(participant.parameters)
                fmu.values.set(participant.parameters)
                fmu.values.set(participant.start)
        self._failed.clear()


def _are_own(fmus: Iterable[Fmu]) -> bool:
    """Whether all are ours, in this process."""
    return all(fmu.is_trusted and not fmu.is_isolated for fmu in fmus)
