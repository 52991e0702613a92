"""The place in a scenario that an FMU's refusal to start belongs to."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from cosim.base.document.node import PathKey
from cosim.base.errors import InputError
from cosim.scenario import Scenario


class placed_refusal:  # noqa: N801 - read as a word of the language, as contextlib's are
    """Give an input error raised inside the place of the value that its sentence names.

    Where it names none: the place of the component's parameters, or of the component. A class,
    because a run enters it thrice for each FMU, and a generator takes four times as long.
    """

    __slots__ = ("_component", "_scenario")

    def __init__(self, scenario: Scenario, component: str) -> None:
        self._scenario, self._component = scenario, component

    def __enter__(self) -> None:
        pass

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if isinstance(error, InputError) and error.location is None:
            path = _path(self._scenario, self._component, error.message)
            raise InputError(error.message, self._scenario.locate(path)) from error


def _path(scenario: Scenario, component: str, sentence: str) -> tuple[PathKey, ...]:
    written = scenario.components[component]
    sections: dict[str, Mapping[str, Any]] = {
        "parameters": written.parameters,
        "start": written.start,
    }
    named = [
        (section, name)
        for section, values in sections.items()
        for name in values
        if re.search(rf"(?<![\w.]){re.escape(name)}(?!\w)", sentence)
    ]
    if named:
        paths = [("components", component, *value) for value in named]
        return max(paths, key=lambda path: _suspicion(scenario, path))
    return ("components", component, *(["parameters"] if written.parameters else []))


def _suspicion(scenario: Scenario, path: tuple[str, str, str, str]) -> tuple[bool, bool, int]:
    """What was written last is the likeliest: an override, then an overlay; then the longest name.

    A sentence names every value of a rule ("mass, inertia and side must be positive").
    """
    place = scenario.locate(path)
    is_other = (Path.cwd() / place.file).resolve() != scenario.file.resolve()
    return place.line == 0, is_other, len(path[3])
