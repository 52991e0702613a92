"""Whatever is changed in a scenario, the theory answers for that run, or refuses by name.

A run obeys the characteristic polynomial of its own map and of no other (Cayley and Hamilton): the
recorded motion is held against the map's eigenvalues, and against those of the scenario before it
was changed.
"""

from __future__ import annotations

import numpy as np
import pytest

from cosim.analysis.answers.asked import ask
from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from cosim.scenario.load import read
from tests.support.theory.mutations import BODIES, NAMES, mutations

KICKS = {
    "hand_1": (0.011, 0.13),
    "hand_2": (-0.004, -0.21),
    "object": (0.002, 0.05),
    "object_1": (0.002, 0.05),
    "object_2": (-0.001, 0.02),
}


def still(name: str) -> list[str]:
    sets = [] if name == "single_user" else ["components.step_1.parameters.amplitude=0"]
    for body in BODIES[name]:
        position, velocity = KICKS[body]
        sets.append(f"components.{body}.parameters.initial_position={position}")
        sets.append(f"components.{body}.parameters.initial_velocity={velocity}")
    return sets


def motion(name: str, sets: list[str], every: int, rows: int) -> np.ndarray:
    """Velocities of a free run at the starts of its hyperperiods, shape (rows, bodies)."""
    sink = MemorySink()
    rate = 2048 if any("base_rate=2048" in text for text in sets) else 1024
    length = f"duration={(rows + 2) * every / rate} s"
    record = f"record=[{', '.join(f'{body}.velocity' for body in BODIES[name])}]"
    with assemble(read(name, (), [*still(name), *sets, length, record]).built()) as simulation:
        simulation.run(sink)
    columns = []
    for body in BODIES[name]:
        signal = sink.signal(f"{body}.velocity")
        slower = 512 if any(f"components.{body}.rate=512" in text for text in sets) else 1024
        columns.append(signal[:: every * slower // rate][:rows])
    return np.column_stack(columns)


def disobeys(values: np.ndarray, seen: np.ndarray) -> float:
    """How far a motion is from obeying the recurrence that eigenvalues make."""
    coefficients = np.real(np.poly(values))
    order = coefficients.size - 1
    worst = 0.0
    for column in seen.T:
        windows = np.lib.stride_tricks.sliding_window_view(column, order + 1)[:, ::-1]
        size = np.abs(windows) @ np.abs(coefficients)
        worst = max(worst, float(np.max(np.abs(windows @ coefficients) / np.maximum(size, 1e-30))))
    return worst


def spectrum(name: str, sets: list[str]) -> tuple[np.ndarray, int]:
    with ask(read(name, (), [*still(name), *sets])) as asked:
        point = asked.point()
        values = np.linalg.eigvals(point.matrix)
        return values[np.abs(values) > 1e-3], point.run.hyperperiod


@pytest.mark.one_in(4)
@pytest.mark.parametrize("batch", range(20))
def test_a_mutated_run_obeys_the_polynomial_of_its_own_map(batch: int) -> None:
    generator = np.random.default_rng(100 + batch)
    refused = 0
    for number in range(10):
        name = NAMES[(batch + number) % 3]
        sets = mutations(generator, name)
        try:
            values, every = spectrum(name, sets)
        except InputError:  # by name, which is an answer as well
            refused += 1
            continue
        before, every_before = spectrum(name, [])
        # What the start left in flight and dies at once is over after a few hyperperiods.
        rows = motion(name, sets, every, values.size + 30)[8:]
        growth = float(np.max(np.abs(values)))
        if growth > 3.0:
            rows = rows[: values.size + 6]
        own = disobeys(values, rows)
        assert own < 1e-7, (name, sets, own)
        changed = values.size != before.size or not np.allclose(np.poly(values), np.poly(before))
        if every == every_before and changed:
            assert disobeys(before, rows) > 10 * own, (name, sets)
    assert refused <= 2


def test_what_is_turned_on_the_way_is_refused_by_name() -> None:
    """The theory is of one plan; without the events it answers for that one."""
    with (
        pytest.raises(
            InputError, match=r"lan.forward.delay is turned at tick 1536, and the theory"
        ),
        ask(read("single_axis_turned")) as asked,
    ):
        asked.point()
    turned = "knobs={lan.loss: {maximum: 0.2}}"
    wire = "connections=[{from: step_1.value, to: lan.loss}]"
    with (
        pytest.raises(InputError, match=r"step_1.value -> lan.loss turns a channel"),
        ask(read("single_axis_distributed", (), [turned, wire])) as asked,
    ):
        asked.point()
    with ask(read("single_axis_turned", (), ["events=~"])) as asked:
        size = asked.point().run.size
    with ask(read("single_axis_distributed")) as asked:
        assert asked.point().run.size == size


def test_a_run_that_starts_late_is_asked_at_its_own_time() -> None:
    sets = ["start_time=2", "components.step_1.parameters.start_time=2.1"]
    with (
        ask(read("single_axis_distributed", (), sets)) as late,
        ask(read("single_axis_distributed")) as plain,
    ):
        assert late.point().tick == plain.point().tick
        np.testing.assert_array_equal(late.point().run.numbers(), plain.point().run.numbers())
