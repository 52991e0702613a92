"""A scenario as every command reads it: each section judged by the form of those who obey it.

This is the one module that names all of them, so that the reader itself need not know them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, cast

from cosim.base.arguments import texts_of
from cosim.base.errors import InputError
from cosim.base.system.installed import registered

if TYPE_CHECKING:
    from pydantic import BaseModel

    from cosim.scenario import Scenario
    from cosim.scenario.form.sections import Forms


def _safety() -> type[BaseModel]:
    """Registered by the package that has the safety layer, as devices are."""
    for entry in registered("cohaptic.sections"):
        if entry.name == "safety":
            form: type[BaseModel] = entry.load()
            return form
    raise InputError(
        "the installed cohaptic does not say what may stand in 'safety:'; its files are newer than "
        "its installation: install it again, such as with uv sync."
    )


def _realtime() -> type[BaseModel]:
    from cosim.realtime.form import RealtimeForm

    return RealtimeForm


def _link() -> type[BaseModel]:
    from cosim.link.stream.form import LinkForm

    return LinkForm


def _expect() -> type[BaseModel]:
    from cosim.report.expectation_form import expect_form

    return expect_form()


FORMS: Forms = {"safety": _safety, "realtime": _realtime, "link": _link, "expect": _expect}


def edit(scenario: str | PathLike[str] | Scenario, values: Mapping[str, Any]) -> Scenario:
    """A scenario with other values, by place: ``{"components.hand.parameters.mass": 0.2}``.

    Places are those of ``--set``; the scenario that is given stays as it is. A class of a component
    stands for its module and name: ``{"components.hand.python": MyHand}``; NumPy's numbers and
    arrays, fractions and paths are values like others.

    Raises:
        InputError: one or more (``InputErrors``) problems, each with its place.
        TypeError: ``values`` is no mapping from places to values.
    """
    scenario = scenario_of(scenario)
    from cosim.analysis.compensation import tuned_scenario
    from cosim.scenario.load import Written

    sets = [f"{place}={_written(value)}" for place, value in _by_place(values).items()]
    return tuned_scenario(Written(scenario.file, scenario.root, FORMS).changed(sets))


def _by_place(values: Any) -> Mapping[str, Any]:
    by_place: Mapping[Any, Any] | None = None
    if isinstance(values, Mapping):
        by_place = cast("Mapping[Any, Any]", values)
    if by_place is None or not all(isinstance(place, str) for place in by_place):
        raise TypeError(
            "values is a mapping from places to values, such as "
            f"{{'components.hand.parameters.mass': 0.2}}, not {values!r}."
        )
    return by_place


def _written(value: Any) -> str:
    """A value as YAML, on one line."""
    if isinstance(value, type):
        return _named(value)
    return value if isinstance(value, str) else json.dumps(value, default=_plain)


def _plain(value: Any) -> Any:
    """What JSON does not know: NumPy's values, exact numbers, paths and classes.

    Raises:
        InputError: it is something else.
    """
    if isinstance(value, PathLike):
        return fspath(cast("PathLike[str]", value))
    if isinstance(value, Fraction | Decimal):
        return str(value)
    to_list = None if isinstance(value, type) else getattr(value, "tolist", None)
    return _named(value) if to_list is None else to_list()


def _named(value: Any) -> str:
    """A class as ``module:Class``.

    Raises:
        InputError: it is no class, or one that only a function has.
    """
    if not isinstance(value, type):
        raise InputError(f"{value!r} is no value that a scenario can have.")
    if "." in value.__qualname__:
        raise InputError(
            f"{value.__qualname__}: a scenario finds a class by its module and its name; define it "
            "at the top of a module, or of the notebook."
        )
    return f"{value.__module__}:{value.__qualname__}"


def load(
    path: str | PathLike[str],
    overlays: Sequence[str | PathLike[str]] = (),
    sets: Sequence[str] = (),
) -> Scenario:
    """Read and check a scenario, with numbers in place of every ``compensation: auto``.

    ``path`` and ``overlays`` are found as files first and then by bundled name, ``-`` is standard
    input; ``sets`` are ``a.b=c`` overrides.

    Raises:
        InputError: one or more (``InputErrors``) problems, each with its place.
        TypeError: ``overlays`` or ``sets`` is no list of texts.
    """
    from cosim.analysis import load_tuned

    over = texts_of("overlays", overlays), texts_of("sets", sets)
    return load_tuned(path, *over, forms=FORMS)


def scenario_of(scenario: str | PathLike[str] | Scenario, sets: Sequence[str] = ()) -> Scenario:
    """What is given, read with ``sets`` where it is a name or a file.

    Raises:
        InputError: it cannot be read.
        TypeError: it is something else, or ``sets`` go with what was read already.
    """
    from cosim.scenario import Scenario

    if isinstance(scenario, str | PathLike):
        return load(scenario, sets=sets)
    given: Any = scenario
    if not isinstance(given, Scenario):
        raise TypeError(f"a scenario is a name, a file, or what load() returns, not {given!r}.")
    if sets:
        raise TypeError("sets goes with a name or a file; edit() changes a scenario.")
    return scenario
