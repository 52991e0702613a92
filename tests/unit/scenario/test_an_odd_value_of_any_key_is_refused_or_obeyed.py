"""Any value at any key of a scenario: refused at a place in its file, or the run is another one.

The keys are those of the forms, through the cases that show what each does; so a new key is here by
itself.
"""

from __future__ import annotations

import copy
import math
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError, InputErrors, RunError
from tests.support.forms.scenario_cases import CASES, document
from tests.unit.scenario.test_every_key_of_a_scenario_is_obeyed import effect

ODD: tuple[Any, ...] = (
    *(-1, 0, 1.5, 1e300, -1e300, 1e-300, 2**70, math.nan, math.inf, True),
    *("", "3 parsec", "nosuch", "1e400", "1e-400 s", "-3 s", [], {}, [1, 1], [[]], {"nosuch": 1}),
)
Place = tuple[str | int, ...]
SEED = 13


def nodes(value: Any, path: Place = ()) -> Iterator[Place]:
    """The places of everything inside a document."""
    if path:
        yield path
    inner: Any = value.items() if isinstance(value, dict) else ()
    for key, each in enumerate(value) if isinstance(value, list) else inner:
        yield from nodes(each, (*path, key))


def at(value: Any, path: Place) -> Any:
    for key in path:
        is_there = key in value if isinstance(value, dict) else isinstance(value, list)
        if not is_there or (isinstance(value, list) and int(key) >= len(value)):
            return None
        value = value[key]
    return value


def put(value: Any, path: Place, other: Any) -> Any:
    made = copy.deepcopy(value)
    at(made, path[:-1])[path[-1]] = other
    return made


def own_places() -> list[tuple[str, dict[str, Any], Place]]:
    """What the two documents of each case do not share, where it stands in the second."""
    found: dict[tuple[str, Place], dict[str, Any]] = {}
    for (form, _), (common, one, two) in sorted(CASES.items()):
        first, second = document(common, one), document(common, two)
        for path in nodes(second):
            if at(first, path) != at(second, path):
                found.setdefault((form, path), second)
    return [(form, written, path) for (form, path), written in found.items()]


ALL = [(place, value) for place in own_places() for value in ODD]


@pytest.mark.parametrize(
    "count", [200, pytest.param(len(ALL), marks=pytest.mark.exhaustive, id="all")]
)
def test_it_is_refused_where_it_stands_or_has_an_effect(count: int, tmp_path: Path) -> None:
    outcomes = {"refused": 0, "obeyed": 0}
    known: dict[str, Any] = {}
    for number, ((form, written, path), value) in enumerate(random.Random(SEED).sample(ALL, count)):
        what = f"{form}: {'.'.join(map(str, path))}: {value!r}"
        if at(written, path) == value:
            continue
        try:
            found = effect(put(written, path, value), tmp_path / str(number))
        except InputError as error:
            for each in error.errors if isinstance(error, InputErrors) else [error]:
                assert each.location is not None, (what, str(each))
            outcomes["refused"] += 1
            continue
        except RunError:
            outcomes["obeyed"] += 1
            continue
        except Exception as error:
            error.add_note(what)
            raise
        key = repr(written)
        if key not in known:
            known[key] = effect(written, tmp_path / f"{number} as it was")
        assert found != known[key], f"{what} was accepted and does nothing"
        outcomes["obeyed"] += 1
    assert all(outcomes.values()), outcomes
