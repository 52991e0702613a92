"""A sweep as it is planned: from a file or from options to a job and its points."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from cosim.base.document.form import plain_node, read_form
from cosim.base.document.show import show
from cosim.base.document.yaml_reader import read_yaml
from cosim.base.errors import InputError, Location
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.base.suggest import did_you_mean
from cosim.report.measures import SCENARIO_MEASURES
from cosim.report.window import MEASURES
from cosim.scenario.form.sections import Forms
from cosim.scenario.load import Written, read
from cosim.scenario.source.find import find_file
from cosim.scenario.source.merge import merge, normalise
from cosim.sweep.job import Job
from cosim.sweep.planning.axis import SweepAxis, Value, check_units, parse_values
from cosim.sweep.planning.design import Point, Sampling, points_of
from cosim.sweep.planning.form import AxisForm, PlanForm
from cosim.sweep.planning.places import expand

SEED = "seed"
OF_A_RUN = (
    *("number", "status", "message", "ticks", "seconds", "checked"),
    "spectral_radius",
)
"""Columns of the table that no variable may be called as."""
_DURATION = "duration"


@dataclass(frozen=True, slots=True)
class SweepPlan:
    """What is run: the job, and the points in the order of their numbers."""

    name: str
    job: Job
    points: tuple[Point, ...]
    boundary: bool = False
    """Whether the points are a grid of two axes of which only what is needed is run."""

    @property
    def expectations(self) -> Any:
        """What a good run is, as it is written."""
        node = self.job.written.root.child("expect")
        return None if node is None else node.plain()

    @property
    def axes(self) -> tuple[SweepAxis, ...]:
        """What is varied."""
        return self.job.axes

    def cost(self, number: int) -> float:
        """What a run costs beside others: its simulated time (s) where that varies, else 1."""
        for axis, value in zip(self.axes, self.points[number], strict=True):
            if _DURATION in axis.places:
                try:
                    return float(quantity(value, "s"))
                except QuantityError:  # it is refused, which takes no time
                    return 0.0
        return 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What a user asks for, whether in a file, on the command line or in Python.

    ``vary`` maps a variable's name to its values, as text (``0..39``) or listed, or to a mapping of
    ``set`` (places) and ``values``.
    """

    scenario: str | Path | Written
    overlays: Sequence[str | Path] = ()
    sets: Sequence[str] = ()
    vary: Mapping[str, Any] = field(default_factory=dict[str, Any])
    seeds: int | None = None
    sample: str = "grid"
    points: int | None = None
    sample_seed: int | None = None
    boundary: bool = False
    start: str | float | None = None
    expect: Mapping[str, Any] = field(default_factory=dict[str, Any])
    measure: Mapping[str, str | Sequence[str]] = field(
        default_factory=dict[str, "str | Sequence[str]"]
    )
    check_every: int = 100


def is_plan(path: Path) -> bool:
    """Whether a file is the plan of a sweep, and no scenario."""
    try:
        return read_yaml(path, str(path)).child("sweep") is not None
    except InputError:
        return False


def read_plan(path: Path) -> Request:
    """A plan from its file; a scenario that it names is looked for beside it first.

    Raises:
        InputError: everything that is wrong with the file, each with its place.
    """
    form = read_form(PlanForm, read_yaml(path, str(path)), "a sweep's plan")
    return Request(
        scenario=_beside(path, form.scenario),
        overlays=[_beside(path, each) for each in form.overlays],
        sets=form.sets,
        vary={name: _plain(axis) for name, axis in form.vary.items()},
        seeds=form.seeds,
        sample=form.sample,
        points=form.points,
        sample_seed=form.sample_seed,
        boundary=form.boundary,
        start=form.start,
        expect=form.expect,
        measure=form.measure,
        check_every=form.check_every,
    )


def plan_of(request: Request, forms: Forms | None = None) -> SweepPlan:
    """The plan that a request makes, with the scenario read.

    Raises:
        InputError: the scenario cannot be read, or what is asked for cannot be.
    """
    given = request.scenario
    if isinstance(given, Written):
        written = given.changed(request.sets)
    else:
        written = read(given, request.overlays, request.sets, forms=forms)
    written = _expecting(written, request.expect)
    axes = [_axis(written, name, given) for name, given in request.vary.items()]
    if request.seeds is not None:
        if request.seeds < 1:
            raise InputError(f"seeds: {request.seeds} seeds are none; give 1 or more.")
        if any(SEED in axis.places for axis in axes):
            raise InputError("seeds: the seed is varied already.")
        axes.append(SweepAxis(SEED, (SEED,), tuple(range(1, request.seeds + 1))))
    if not axes:
        raise InputError("nothing is varied: give --vary or --seeds, or 'vary' in the plan.")
    _refuse_twice(axes)
    sample = _sampling(request.sample)
    if sample is Sampling.GRID and request.sample_seed is not None:
        raise InputError("a grid draws nothing; leave 'sample_seed' out.")
    points = points_of(axes, sample, request.points, request.sample_seed or 0)
    if request.boundary:
        _check_boundary(axes, sample)
    job = Job(
        written=written,
        axes=tuple(axes),
        readings=tuple(_readings(request.measure)),
        start=None if request.start is None else str(request.start),
        check_every=request.check_every,
    )
    return SweepPlan(written.file.stem, job, tuple(points), request.boundary)


def _beside(plan: Path, name: str) -> str | Path:
    """A file beside the plan, or what it is called from anywhere."""
    file = plan.parent / name
    return file if file.is_file() else find_file(name)


def _plain(axis: AxisForm | str | list[Any]) -> Any:
    return axis.model_dump(exclude_none=True) if isinstance(axis, AxisForm) else axis


def _axis(written: Written, name: str, given: Any) -> SweepAxis:
    places: Any = name
    if isinstance(given, Mapping):
        members = cast("Mapping[str, Any]", given)
        unknown = sorted(set(members) - {"set", "values"})
        if unknown or "values" not in members:
            raise InputError(f"{name}: write its 'values', and 'set' for where they go.")
        places, given = members.get("set", name), members["values"]
    several = [places] if isinstance(places, str) else list(places)
    found = [path for place in several for path in expand(written.root, str(place))]
    if isinstance(given, str):
        values, span = parse_values(name, given)
    elif isinstance(given, Iterable):
        values, span = tuple(_value(name, each) for each in cast("Iterable[Any]", given)), None
    else:
        raise InputError(
            f"{name}: write a list of values or a range such as 0..39, not {show(given)}."
        )
    if not values:
        raise InputError(f"{name} has no values.")
    check_units(name, values)
    return SweepAxis(name, tuple(dict.fromkeys(found)), values, span)


def _value(name: str, given: Any) -> Value:
    """A value as it would be written: NumPy's numbers as numbers, lists as they stand in YAML."""
    given = given.item() if hasattr(given, "item") else given
    if isinstance(given, list | tuple):
        return f"[{', '.join(str(_value(name, each)) for each in cast('Sequence[Any]', given))}]"
    if not isinstance(given, int | float | str | bool):
        raise InputError(
            f"{name}: {show(given)} is no value; give numbers, words or lists of them."
        )
    return given


def _sampling(name: str) -> Sampling:
    if name not in set(Sampling):
        raise InputError(f"sample: there is no '{name}'.{did_you_mean(name, list(Sampling))}")
    return Sampling(name)


def _refuse_twice(axes: Sequence[SweepAxis]) -> None:
    users: dict[str, str] = {}
    for axis in axes:
        if axis.name in OF_A_RUN or axis.name in SCENARIO_MEASURES:
            raise InputError(
                f"{axis.name} is a column of every sweep's table; give the variable another name."
            )
        for place in axis.places:
            other = users.setdefault(place, axis.name)
            if other != axis.name:
                raise InputError(f"{place} is varied by {other} and by {axis.name}.")


def _check_boundary(axes: Sequence[SweepAxis], sample: Sampling) -> None:
    if len(axes) != 2 or sample is not Sampling.GRID or any(len(axis.values) < 2 for axis in axes):
        raise InputError("boundary: a boundary is found in a grid of two variables, nothing else.")


def _readings(measure: Mapping[str, str | Sequence[str]]) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    for target, names in measure.items():
        for name in [names] if isinstance(names, str) else names:
            if name not in MEASURES or name == "amplitude":
                known = [each for each in MEASURES if each != "amplitude"]
                raise InputError(
                    f"measure: there is no measure '{name}'.{did_you_mean(name, known)}"
                )
            found.append((target, name))
    return found


def _expecting(written: Written, expect: Mapping[str, Any]) -> Written:
    if not expect:
        return written
    place = Location("the sweep's expect", 0, 0)
    over = normalise(plain_node({"expect": dict(expect)}, place), ())
    return Written(written.file, merge(written.root, over), written.forms)
