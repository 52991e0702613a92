"""A force of one newton on a hand is that newton in the theory, however a user's force is written.

The same loop under the same force has one admittance and one damping; where what pushes a hand
changes its size, is late or pushes another hand too, no number is given.
"""

from __future__ import annotations

import numpy as np
import pytest

from cosim.analysis.answers.asked import ask
from cosim.analysis.answers.felt import felt_response
from cosim.analysis.answers.grasp_damping import null_grasp_damping
from cosim.analysis.answers.push import find_push
from cosim.base.errors import InputError
from cosim.scenario.load import read

ONE_AXIS, BOX = "single_user", "two_users_box"
FREQUENCY = np.array([100.0])
ON_Y = 1


def felt(name: str, sets: list[str], axis: int = 0) -> complex:
    with ask(read(name, (), sets)) as asked:
        push = find_push(asked.scenario, None, axis)
        return complex(felt_response(asked.point(), push, "free", FREQUENCY).fundamental[0])


def operator(**given: str) -> list[str]:
    return [f"components.operator_a1.parameters.{key}={value}" for key, value in given.items()]


@pytest.mark.parametrize(
    ("written", "said"),
    [
        (
            "connections.0={from: step_1.value, to: hand_1.force, factor: 2}",
            r"step_1.value -> hand_1.force.*has a factor",
        ),
        (
            "connections.0=step_1.value -> hand_1.force delay 8 ticks",
            "a delay or a rate of its own",
        ),
        ("connections.0=step_1.value -> hand_1.force at 64 Hz", "a delay or a rate of its own"),
        ("connections.0=step_1.rate -> hand_1.force", "connect step_1.value"),
    ],
)
def test_what_does_not_bring_a_hand_its_newton_is_refused(written: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        felt(ONE_AXIS, [written])


def test_a_signal_that_pushes_another_part_too_is_refused() -> None:
    wires = [*map(str, read(ONE_AXIS).built().connections), "step_1.value -> object.force[2]"]
    with pytest.raises(InputError, match=r"object.force\[2\].*pushes this too"):
        felt(ONE_AXIS, [f"connections=[{', '.join(map(repr, wires))}]"])


def test_what_is_added_throughout_does_not_count() -> None:
    shifted = "connections.0={from: step_1.value, to: hand_1.force, offset: 0.5}"
    assert felt(ONE_AXIS, [shifted]) == pytest.approx(felt(ONE_AXIS, []), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "force",
    [
        operator(force_rectify="[true, true]"),
        operator(force_mode="[step, step]", force_duration="[0, 0.5]"),
        operator(force_mode="[step, sine]", force_duration="[0, 0.5]"),
    ],
    ids=["pushes only", "was a step", "was a sine"],
)
def test_a_users_force_counts_in_full_whatever_made_it(force: list[str]) -> None:
    assert felt(BOX, force, ON_Y) == pytest.approx(felt(BOX, [], ON_Y), rel=1e-3)


def test_a_force_on_two_fingers_is_not_one_on_the_hand() -> None:
    wires = read(BOX).built().connections
    number = next(n for n, w in enumerate(wires) if str(w.target) == "finger_a2.hand_force")
    both = f"connections.{number}=operator_a1.force -> finger_a2.hand_force"
    with pytest.raises(InputError, match=r"operator_a1.force -> finger_a2.hand_force.*this too"):
        felt(BOX, [both])
    with (
        ask(read(BOX, (), [both])) as asked,
        pytest.raises(InputError, match="this too"),
    ):
        null_grasp_damping(asked, None)
