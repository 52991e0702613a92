"""What is asked of a scenario: what runs, at which moment, and how its parameters are called."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from cosim.analysis.answers.names import names_of, overrides
from cosim.analysis.compensation import tuned
from cosim.analysis.monodromy.idealised import WINDOW, idealised
from cosim.analysis.monodromy.point import Point, find_point
from cosim.analysis.monodromy.spares import Spares
from cosim.analysis.parameter import is_number
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.scenario import Scenario
from cosim.scenario.load import Written


@dataclass(slots=True)
class AskedRun:
    """A scenario and a moment of it.

    Attributes:
        written: what runs, with everything changed that is asked for.
        scenario: the same, built.
        at: the moment (s), or None for the last one at which it rests.
        notes: what is left out, for people.
        names: the scenario's paths behind each name of the thesis; empty where it has none.
    """

    written: Written
    scenario: Scenario
    at: Fraction | None
    notes: tuple[str, ...]
    names: Mapping[str, tuple[str, ...]]
    _points: dict[tuple[str, ...], Point] = field(default_factory=dict[tuple[str, ...], Point])
    _spares: Spares = field(default_factory=Spares)

    def point(self, sets: Sequence[str] = (), near: Point | None = None) -> Point:
        """The operating point with further overrides; kept until ``forget`` or ``close``."""
        key = tuple(sets)
        if key not in self._points:
            written = self.written.changed(sets) if sets else self.written
            if near is None and sets and not self.point().run.is_linear:
                near = self.point()
            self._points[key] = find_point(written, self.at, near, self._spares)
        return self._points[key]

    def fresh(self, sets: Sequence[str]) -> Point:
        """The operating point of a run of another shape, which the caller closes."""
        return find_point(self.written.changed(sets), self.at)

    def forget(self, sets: Sequence[str]) -> None:
        """Leave the point of these overrides; its simulation serves another one."""
        point = self._points.pop(tuple(sets), None)
        if point is not None:
            self._spares.take(point.run.simulation)

    def close(self) -> None:
        """Close every point."""
        for point in self._points.values():
            point.close()
        self._points.clear()
        self._spares.close()

    def __enter__(self) -> AskedRun:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def paths_of(self, name: str) -> tuple[str, ...]:
        """The scenario's paths behind a name: of the thesis, a dotted path, or a parameter's.

        Raises:
            InputError: there is nothing of that name.
        """
        if "." in name:
            return (name,)
        if name in self.names:
            return self.names[name]
        parts = self.scenario.components.values()
        found = tuple(
            f"components.{part.name}.parameters.{name}"
            for part in parts
            if is_number(part.parameters.get(name))
        )
        if found:
            return found
        known = {*self.names, *(key for part in parts for key in part.parameters)}
        raise InputError(
            f"The scenario has no parameter {name!r}.{did_you_mean(name, known, listed=0)} Give "
            "one that its components are given, or a path such as components.NAME.parameters.KEY."
        )

    def sets(self, name: str, value: float) -> tuple[str, ...]:
        """The overrides that give a parameter a value (SI units)."""
        return tuple(f"{path}={value!r}" for path in self.paths_of(name))


def ask(
    written: Written,
    *,
    at: Fraction | None = None,
    settings: Sequence[tuple[str, float]] = (),
    ideal: bool = True,
    window: int = WINDOW,
) -> AskedRun:
    """Put together what is asked for.

    Args:
        written: the scenario, with overlays and overrides.
        at: the moment (s).
        settings: parameters by the names of the thesis or of components.
        ideal: take out what has no derivative.
        window: ticks of the difference that stands for FOAW.

    Raises:
        InputError: a name that is none, or a problem of the scenario.
    """
    written = tuned(written)
    scenario = written.built()
    if settings:
        written = written.changed(overrides(scenario, dict(settings)))
        scenario = written.built()
    notes: tuple[str, ...] = ()
    if ideal:
        taken = idealised(written, scenario, window)
        written, notes = taken.written, taken.notes
        scenario = written.built() if notes else scenario
    return AskedRun(written, scenario, at, notes, names_of(scenario))
