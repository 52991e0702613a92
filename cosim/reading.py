"""A scenario as every command reads it: each section judged by the form of those who obey it.

This is the one module that names all of them, so that the reader itself need not know them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

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


def edit(scenario: Scenario, values: Mapping[str, Any]) -> Scenario:
    """A scenario with other values, by place: ``{"components.hand.parameters.mass": 0.2}``.

    Places are those of ``--set``; the scenario that is given stays as it is. A class of a component
    stands for its module and name: ``{"components.hand.python": MyHand}``.

    Raises:
        InputError: one or more (``InputErrors``) problems, each with its place.
    """
    from cosim.analysis.compensation import tuned
    from cosim.scenario.load import Written

    sets = [f"{place}={_written(value)}" for place, value in values.items()]
    return tuned(Written(scenario.file, scenario.root, FORMS).changed(sets)).built()


def _written(value: Any) -> str:
    """A value as YAML, on one line."""
    if isinstance(value, type):
        return _named(value)
    return value if isinstance(value, str) else json.dumps(value, default=_named)


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
    """
    from cosim.analysis import load_tuned

    return load_tuned(path, overlays, sets, forms=FORMS)
