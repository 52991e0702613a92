"""The place in a scenario that an FMU's refusal to start belongs to."""

from __future__ import annotations

import re
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from typing import Any

from cosim.base.errors import InputError
from cosim.base.node import PathKey
from cosim.scenario import Scenario


@contextmanager
def placed_refusal(scenario: Scenario, component: str) -> Generator[None]:
    """Give an input error raised inside the place of the value that its sentence names.

    Where it names none: the place of the component's parameters, or of the component.
    """
    try:
        yield
    except InputError as error:
        if error.location is not None:
            raise
        place = scenario.locate(_path(scenario, component, error.message))
        raise InputError(error.message, place) from error


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
        return ("components", component, *max(named, key=lambda place: len(place[1])))
    return ("components", component, *(["parameters"] if written.parameters else []))
