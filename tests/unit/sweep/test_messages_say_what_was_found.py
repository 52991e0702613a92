"""What travels between a pool and its workers arrives as it was, whatever kind of number it is."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cosim.sweep.job import RunResult, Task
from cosim.sweep.work.messages import ResultReader, ResultWriter, task_bytes, task_of

NUMBERS = st.floats() | st.integers(-(2**70), 2**70)
VALUES = st.booleans() | st.text() | NUMBERS


@given(st.integers(0, 2**40), st.lists(VALUES).map(tuple))
def test_a_task_arrives(number: int, point: tuple[bool | str | float | int, ...]) -> None:
    found = task_of(task_bytes(Task(number, point, "the key stays")))
    assert (found.number, repr(found.point)) == (number, repr(point))


NAMES = st.lists(st.text(), max_size=3, unique=True)
RESULTS = st.builds(
    RunResult,
    number=st.just(7),
    key=st.just("k"),
    point=st.just((1, "b")),
    status=st.sampled_from(["good", "failed", "error", "refused"]),
    message=st.text(),
    measures=NAMES.flatmap(lambda names: st.fixed_dictionaries(dict.fromkeys(names, NUMBERS))),
    passed=NAMES.flatmap(lambda names: st.fixed_dictionaries(dict.fromkeys(names, st.booleans()))),
    ticks=st.integers(0, 2**40),
    seconds=st.floats(0, 1e6),
    checked=st.booleans(),
)


@given(st.lists(RESULTS, max_size=6))
def test_results_arrive_in_their_order(results: list[RunResult]) -> None:
    writer, reader = ResultWriter(), ResultReader()
    task = Task(7, (1, "b"), "k")
    for result in results:
        assert repr(reader.read(writer.write(result), task)) == repr(result)


def test_numbers_of_numpy_are_numbers() -> None:
    odd = RunResult(
        1, "", (), "good", "", {"a": np.float64(0.1), "b": math.nan}, {"c": np.bool_(False)}
    )  # type: ignore[dict-item]
    found = ResultReader().read(ResultWriter().write(odd), Task(1, ()))
    assert repr(found) == repr(
        replace(odd, measures={"a": 0.1, "b": math.nan}, passed={"c": False})
    )
