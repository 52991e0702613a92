"""Numbers moved together, one by one, or by a structure that is wrong: one derivative, bit by bit.

And a simulation that has served another run says what a new one says.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from cosim.analysis.answers.asked import ask
from cosim.analysis.chance.fate import LOST, PeriodFate
from cosim.analysis.monodromy.jacobian import jacobian
from cosim.analysis.monodromy.point import Point, find_point
from cosim.analysis.monodromy.run_map import RunMap
from cosim.analysis.monodromy.structure import MapStructure
from cosim.scenario.load import read
from cosim.theory.numerics import Real

PLANAR = [
    pytest.param(name, marks=pytest.mark.slow)
    for name in ("two_users_box", "thesis/grasp_centralized_soft")
]
ONE_AXIS = ["single_axis_distributed", "single_axis_centralized"]


@contextmanager
def standing(name: str) -> Iterator[Point]:
    with ask(read(name)) as asked:
        yield asked.point()


def one_by_one(run: RunMap, *, lost: bool = False) -> Real:
    run.structures.clear()
    return jacobian(run, fates=fates(run) if lost else None)


def fates(run: RunMap) -> dict[int, PeriodFate]:
    return {b.number: LOST for b in run.bundles if b.bundle.channel is not None}


@pytest.mark.parametrize("lost", [False, True])
@pytest.mark.parametrize("name", [*ONE_AXIS, *PLANAR])
def test_together_is_one_by_one(name: str, lost: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    with standing(name) as point:
        run = point.run
        wanted = one_by_one(run, lost=lost)
        if lost:
            one_by_one(run)  # of which the structure with other fates is taken
        calls: list[int] = []
        count = RunMap.__call__
        monkeypatch.setattr(RunMap, "__call__", lambda *given: calls.append(1) or count(*given))
        found = jacobian(run, fates=fates(run) if lost else None)
        assert np.array_equal(found, wanted)
        if not lost:  # they were moved together
            assert len(calls) < 2 * (1 if run.is_linear else 2) * run.size


@pytest.mark.parametrize("name", [*ONE_AXIS, *PLANAR])
def test_a_structure_that_is_wrong_is_noticed(name: str) -> None:
    with standing(name) as point:
        run = point.run
        wanted = one_by_one(run)
        present = np.argwhere(wanted != 0.0)
        chosen = np.random.default_rng(7).choice(len(present), 6, replace=False)
        wrong = [np.eye(run.size) != 0.0, np.zeros((run.size, run.size)) != 0.0]
        for row, column in present[chosen]:
            less = wanted != 0.0
            less[row, column] = False
            wrong.append(less)
        for moved in wrong:
            run.structures[()] = MapStructure(moved)
            assert np.array_equal(jacobian(run), wanted)


@pytest.mark.parametrize("name", [*ONE_AXIS, *PLANAR])
def test_a_simulation_that_has_served_is_as_good_as_a_new_one(name: str) -> None:
    stiffer = {
        "single_axis_distributed": "components.coupler_11.parameters.stiffness={}",
        "single_axis_centralized": "components.coupler_1.parameters.stiffness={}",
        "two_users_box": "components.vr_a.parameters.local_normal_stiffness={}",
        "thesis/grasp_centralized_soft": "components.server.parameters.local_normal_stiffness={}",
    }[name]
    with ask(read(name)) as asked:
        base = asked.point()
        first, second = ([stiffer.format(value)] for value in (820.0, 900.0))
        asked.point(first)
        asked.forget(first)
        served = asked.point(second)
        written = asked.written.changed(second)
        near = None if base.run.is_linear else base
        with find_point(written, None, near) as new:
            assert np.array_equal(served.run.start, new.run.start)
            assert np.array_equal(served.matrix, new.matrix)
        assert not np.array_equal(served.matrix, base.matrix)
