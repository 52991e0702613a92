"""Whatever an FMU does in whichever call, wherever it runs: status, sentence and record are right.

It ends its process, or returns a status that is not well; in the process of the run or in its own,
paced or not. Nothing of this hangs on deadlines that are met.
"""

from __future__ import annotations

import ctypes.util
import faulthandler
import itertools
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.fmus.failing import (
    BOUND,
    CASES,
    PLACES,
    WAYS,
    Case,
    archives,
    check,
    ended,
    is_possible,
)

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="a child needs Linux")

NEVER_CALLED = {"Reset"}
"""Of somebody else's FMU: it is made anew, because what it makes of a reset is not known."""


@pytest.fixture(scope="module", autouse=True)
def _quiet() -> Iterator[None]:
    """Python's own words about a crash would be in between; and both FMUs are compiled."""
    archives()
    was_enabled = faulthandler.is_enabled()
    faulthandler.disable()
    yield
    if was_enabled:
        faulthandler.enable(sys.__stderr__)


def thinned() -> list[tuple[Case, str, str]]:
    """Each call in each place in one way, so that each way comes in each place.

    The types of values are one path in the code, so that a process of its own has some of them.
    """
    found: list[tuple[Case, str, str]] = []
    for place_number, place in enumerate(PLACES):
        ways = itertools.cycle(WAYS[3 * place_number :] + WAYS[: 3 * place_number])
        step = 1 if place == "here" else 4
        for case in CASES[place_number % step :: step]:
            way = next(way for way in ways if is_possible(case, way, "here"))
            if is_possible(case, way, place):
                found.append((case, way, place))
    return found


SOME = thinned()
WHOLE = [
    (case, way, place)
    for place in PLACES
    for case in CASES
    for way in WAYS
    if is_possible(case, way, place)
]


def test_every_call_of_the_binding_is_among_them() -> None:
    """A function that is bound and stands in no case fails here."""
    for version, bound in BOUND.items():
        held = {case.function for case in CASES if case.version == version}
        assert held | {f"fmi{version}{name}" for name in NEVER_CALLED} == set(bound)


def test_every_way_and_every_call_is_tried_by_default() -> None:
    assert {(way, place) for _, way, place in SOME} == set(itertools.product(WAYS, PLACES))
    assert {case for case, _, place in SOME if place == "here"} == set(CASES)


@pytest.mark.parametrize(("case", "way", "place"), SOME, ids=str)
def test_some(tmp_path: Path, case: Case, way: str, place: str) -> None:
    fails(tmp_path, case, way, place)


@pytest.mark.one_in(200)
@pytest.mark.parametrize(("case", "way", "place"), WHOLE, ids=str)
def test_all(tmp_path: Path, case: Case, way: str, place: str) -> None:
    fails(tmp_path, case, way, place)


def fails(folder: Path, case: Case, way: str, place: str) -> None:
    if way == "exception" and ctypes.util.find_library("stdc++") is None:
        pytest.skip("there is no C++ runtime that could throw")
    check(ended(folder, case, way, place), case, way, place)
