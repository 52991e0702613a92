"""The clocks of an FMU of FMI 3.0, as its description declares them.

Sources: FMI 3.0, section 2.2.8 (clocks), section 4.2 (event mode of co-simulation).
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any
from xml.etree import ElementTree as ET

from cosim.base.component import Causality, Variable, VariableType
from cosim.base.errors import InputError
from cosim.base.quantities.quantity import decimal
from cosim.scenario.build.timebase import hertz

MOST_CLOCKS = 62
_MOST_STEPS = 1 << 53
"""Of one FMU: a bit each in one of the kernel's words."""
_VARIABILITIES = ("constant", "fixed", "tunable", "changing", "countdown", "triggered")
_PERIODIC = ("constant", "fixed", "tunable")
_CHOSEN = ("fixed", "tunable")
"""Their interval is the importer's to set, where the description has one (``intervalDecimal``)."""
_TIMES = ("resolution", "intervalCounter", "intervalDecimal", "shiftCounter", "shiftDecimal")


@dataclass(frozen=True, slots=True)
class ClockFacts:
    """One clock: how its ticks come about."""

    name: str
    causality: Causality
    variability: str
    """``intervalVariability``."""
    interval: Fraction | None
    """s; ``None`` where the FMU is asked for it."""
    shift: Fraction
    """Time of the first tick (s), of a periodic one."""
    of: tuple[str, ...]
    """The clocks that it belongs to."""
    has_age: bool = True
    """Whether ``age_of`` is a signal of its own, rather than a variable of the FMU."""

    @property
    def is_periodic(self) -> bool:
        """Whether it ticks at equal intervals."""
        return self.variability in _PERIODIC

    @property
    def is_triggered_input(self) -> bool:
        """Whether it ticks when others want it to."""
        return self.variability == "triggered" and self.causality is Causality.INPUT


@dataclass(frozen=True, slots=True)
class EventFacts:
    """What the kernel has to know of an FMU whose event mode is used."""

    clocks: tuple[ClockFacts, ...]
    clocked: Mapping[str, tuple[str, ...]]
    """The clocks of each variable that belongs to some."""
    at_start: frozenset[str]
    """Clocked outputs with a value in initialisation mode."""
    may_return: bool
    """Whether steps of any length are allowed, so that one may be left at an event."""

    def clock_names(self) -> frozenset[str]:
        """What stands for a clock among the FMU's variables."""
        ages = (age_of(clock.name) for clock in self.clocks if clock.has_age)
        return frozenset((*(clock.name for clock in self.clocks), *ages))

    def triggered(self) -> frozenset[str]:
        """The clocks that the FMU, too, has for others to see or to let tick."""
        return frozenset(clock.name for clock in self.clocks if clock.variability == "triggered")

    def chosen_intervals(self) -> dict[str, float]:
        """The interval (s) of each clock whose interval is the importer's to choose.

        It is what the description proposes.
        """
        return {
            clock.name: float(clock.interval)
            for clock in self.clocks
            if clock.variability in _CHOSEN and clock.interval is not None
        }

    def is_event_input(self, variable: Variable) -> bool:
        """Whether an input is set in event mode: when its clock ticks, or when it has changed."""
        return variable.name in self.clocked or (
            variable.variability == "discrete" and not variable.type.is_text
        )


def age_of(clock: str) -> str:
    """The signal that says how many ticks ago a clock has ticked."""
    return f"{clock}.age"


def clock_variables(clocks: tuple[ClockFacts, ...]) -> list[Variable]:
    """What others see of clocks: how often each has ticked, and how long ago.

    A triggered input is a number, too: it ticks when the number changes.
    """
    found: list[Variable] = []
    for clock in clocks:
        is_input = clock.is_triggered_input
        causality = Causality.OUTPUT if clock.causality is Causality.INPUT else clock.causality
        found.append(
            _whole(
                clock.name,
                Causality.INPUT if is_input else causality,
                "ticks when this number changes" if is_input else "ticks so far",
            )
        )
        if clock.has_age:
            shown = Causality.LOCAL if causality is Causality.LOCAL else Causality.OUTPUT
            about = "base ticks since its last tick; -1 before the first"
            found.append(_whole(age_of(clock.name), shown, about))
    return found


def _whole(name: str, causality: Causality, description: str) -> Variable:
    return Variable(
        name=name,
        type=VariableType.INT64,
        causality=causality,
        variability="discrete",
        start=0 if causality is Causality.INPUT else None,
        description=description,
    )


def read_clocks(root: ET.Element) -> list[dict[str, Any]]:
    """The clocks of a ``modelDescription.xml`` as they are written there."""
    names = {
        each.get("valueReference"): each.get("name", "")
        for each in root.iterfind("ModelVariables/*")
    }
    return [
        {
            "name": each.get("name", ""),
            "causality": each.get("causality", "local"),
            "variability": each.get("intervalVariability", ""),
            "of": tuple(names.get(word, word) for word in each.get("clocks", "").split()),
            **{name: each.get(name) for name in _TIMES},
        }
        for each in root.iterfind("ModelVariables/Clock")
    ]


def clock_facts(written: Mapping[str, Any], taken: Container[str]) -> ClockFacts:
    """A clock of what ``read_clocks`` found; ``taken`` are the names of the FMU's variables.

    Raises:
        InputError: its ticks do not follow from what it says.
    """
    name, variability = written["name"], written["variability"]
    if variability not in _VARIABILITIES:
        raise InputError(
            f"the clock {name} has the intervalVariability '{variability}'; the standard knows "
            f"{', '.join(_VARIABILITIES)}"
        )
    interval, shift = (_time(written, what) for what in ("interval", "shift"))
    if variability == "constant" and interval is None:
        raise InputError(f"the clock {name} is constant and has no intervalDecimal")
    if variability != "triggered" and written["causality"] != "input":
        raise InputError(f"the clock {name} is {variability}, so it has to be an input")
    return ClockFacts(
        name=name,
        causality=Causality(written["causality"]),
        variability=variability,
        interval=interval if variability in _PERIODIC else None,
        shift=Fraction(0) if shift is None else shift,
        of=tuple(written["of"]),
        has_age=age_of(name) not in taken,
    )


def check_membership(clocks: tuple[ClockFacts, ...], clocked: Mapping[str, Iterable[str]]) -> None:
    """Whether everything that belongs to clocks belongs to some that are there.

    Raises:
        InputError: a variable, or a clock, names one that is no clock.
    """
    known = {clock.name for clock in clocks}
    for name, of in (*clocked.items(), *((clock.name, clock.of) for clock in clocks)):
        for other in of:
            if other not in known:
                raise InputError(f"{name} belongs to {other}, which is no clock")


def check_grid(clock: ClockFacts, step: Fraction) -> None:
    """Whether a periodic clock ticks where steps of ``step`` (s) end.

    Raises:
        InputError: it does not; says which rate would do.
    """
    for what, time in (("an interval", clock.interval), ("a shift", clock.shift)):
        if time is None or not clock.is_periodic:
            continue
        if time < 0 or (what == "an interval" and time == 0):
            raise InputError(f"the clock {clock.name} has {what} of {float(time):g} s")
        if time / step > _MOST_STEPS:
            raise InputError(
                f"the clock {clock.name} has {what} of {float(time):g} s, longer than any run; "
                "'event_mode: false' leaves its clocks out"
            )
        if (time / step).denominator != 1:
            raise InputError(
                f"the clock {clock.name} has {what} of {float(time):g} s, which is no whole number "
                f"of the component's steps of {float(step):g} s; write a rate of "
                f"{hertz(1 / time)} or a multiple of it, or 'event_mode: false' to leave its "
                "clocks out"
            )


def _time(written: Mapping[str, Any], what: str) -> Fraction | None:
    """s; the counter and the resolution are exact, where both are there."""
    counter, resolution = written[f"{what}Counter"], written["resolution"]
    text = written[f"{what}Decimal"]
    try:
        if counter is not None and resolution is not None and int(resolution):
            return Fraction(int(counter), int(resolution))
        return None if text is None else decimal(text)
    except ValueError:
        said = text if counter is None or resolution is None else f"{counter} / {resolution}"
        raise InputError(
            f"the clock {written['name']} has the {what} '{said}', which is no time"
        ) from None
