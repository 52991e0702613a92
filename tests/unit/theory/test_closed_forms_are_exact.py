"""(6.3), (B.10) and (B.11)–(B.13) as identities in exact rational arithmetic."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.theory.transparency.damping import (
    centralized_damping_two_samples,
    distributed_damping_two_samples,
    original_damping_two_samples,
)

Vector = list[Fraction]


class Loop:
    """One or two object copies and one hand, in fractions, ticked by hand; packets are (x, v)."""

    def __init__(self, p: dict[str, Fraction], forward: int, backward: int) -> None:
        self.p, self.forward, self.backward = p, forward, backward
        self.size = 6 + 4 * forward + 2 * backward

    def frame(self, state: Vector, force: Fraction, *, direct: bool = False) -> Vector:
        """N = 2 ticks of the distributed loop; ``direct`` puts the force on both copies instead."""
        p, T = self.p, self.p["T"]
        hand, one, two = list(state[0:2]), list(state[2:4]), list(state[4:6])
        there = [state[6 + 4 * i : 10 + 4 * i] for i in range(self.forward)]
        start = 6 + 4 * self.forward
        back = [state[start + 2 * i : start + 2 * i + 2] for i in range(self.backward)]
        there.append([*hand, *one])
        back.append(list(two))
        heard_two, heard_one = there.pop(0), back.pop(0)

        def spring(k: str, b: str, a: Vector, c: Vector) -> Fraction:
            return p[k] * (a[0] - c[0]) + p[b] * (a[1] - c[1])

        def move(body: Vector, push: Fraction, mass: Fraction) -> None:
            body[0] += body[1] * T + push * T * T / (2 * mass)
            body[1] += push * T / mass

        for _ in range(2):
            own = Fraction(0) if direct else spring("k_11", "b_11", hand, one)
            push_one = own + spring("k_o", "b_o", heard_one, one)
            push_two = spring("k_o", "b_o", heard_two[2:4], two)
            if direct:
                push_one, push_two = push_one + force, push_two + force
            else:
                push_two += spring("k_12", "b_12", heard_two[0:2], two)
                move(hand, force - own, p["m_1"])
            move(one, push_one, p["m_o"])
            move(two, push_two, p["m_o"])
        return [*hand, *one, *two, *[v for s in there for v in s], *[v for s in back for v in s]]

    def damping(self, *, direct: bool = False) -> Fraction:
        """F/V of the steady drift at 1 m/s, V read at the start of a frame."""
        zero, one = Fraction(0), Fraction(1)
        moved = [one if i % 2 == 0 else zero for i in range(self.size)]
        used = [i for i in range(self.size) if not (direct and (i < 2 or _of_hand(self, i)))]
        columns: list[Vector] = []
        for index in used[1:]:
            unit = [one if i == index else zero for i in range(self.size)]
            image = self.frame(unit, zero, direct=direct)
            columns.append([image[i] - unit[i] for i in used])
        pushed = self.frame([zero] * self.size, one, direct=direct)
        columns.append([pushed[i] for i in used])
        target = [2 * self.p["T"] * moved[i] for i in used]
        solution = solve(columns, target)
        # The velocity of the body that is felt is the entry after the position that was fixed.
        return solution[-1] / solution[0]


def _of_hand(loop: Loop, index: int) -> bool:
    """Whether an entry is the hand's part of a packet under way."""
    return 6 <= index < 6 + 4 * loop.forward and (index - 6) % 4 < 2


def solve(columns: list[Vector], target: Vector) -> Vector:
    """Gaussian elimination over the rationals."""
    n = len(target)
    rows = [[column[i] for column in columns] + [target[i]] for i in range(n)]
    for pivot in range(n):
        best = next(i for i in range(pivot, n) if rows[i][pivot] != 0)
        rows[pivot], rows[best] = rows[best], rows[pivot]
        rows[pivot] = [value / rows[pivot][pivot] for value in rows[pivot]]
        for i in range(n):
            if i != pivot and rows[i][pivot] != 0:
                factor = rows[i][pivot]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[pivot], strict=True)]
    return [row[-1] for row in rows]


def printed(p: dict[str, Fraction]) -> Fraction:
    values: dict[str, Any] = {name: value for name, value in p.items() if name != "T"}
    return Fraction(original_damping_two_samples(T_c=p["T"], **values))


TABLE_6_1 = {
    "T": Fraction(1, 1024),
    "m_1": Fraction(1, 10),
    "m_o": Fraction(2, 5),
    "k_11": Fraction(3000),
    "b_11": Fraction(20),
    "k_12": Fraction(400),
    "b_12": Fraction(2),
    "k_o": Fraction(300),
    "b_o": Fraction(10),
}
POINTS = st.fixed_dictionaries(
    {
        name: st.fractions(value / 4, value * 4, max_denominator=10000)
        for name, value in TABLE_6_1.items()
    }
)


@pytest.mark.parametrize("split", [(1, 0), (0, 1)])
def test_b_11_to_b_13_are_exact_at_table_6_1_for_one_sample(split: tuple[int, int]) -> None:
    assert Loop(TABLE_6_1, *split).damping() == printed(TABLE_6_1)


@settings(deadline=None, max_examples=15)
@given(POINTS)
def test_b_11_to_b_13_are_exact_everywhere(p: dict[str, Fraction]) -> None:
    assert Loop(p, 1, 0).damping() == printed(p)


def test_b_11_to_b_13_do_not_hold_without_delay() -> None:
    assert Loop(TABLE_6_1, 0, 0).damping() != printed(TABLE_6_1)


@settings(deadline=None, max_examples=15)
@given(POINTS)
def test_equation_6_3_is_exact_without_delay(p: dict[str, Fraction]) -> None:
    closed: Any = distributed_damping_two_samples
    assert Loop(p, 0, 0).damping(direct=True) == closed(p["m_o"], p["k_o"], p["b_o"], p["T"])


@settings(deadline=None, max_examples=15)
@given(POINTS)
def test_equation_b_10_is_exact(p: dict[str, Fraction]) -> None:
    """The remote user alone: hand 2 and the object, N = 2, no delay, by the same elimination."""
    T, k, b, m_h, m_o = p["T"], p["k_12"], p["b_12"], p["m_1"], p["m_o"]

    def frame(state: Vector, force: Fraction) -> Vector:
        x_h, v_h, x_o, v_o = state
        sent = k * x_h + b * v_h
        down = sent - k * x_o - b * v_o
        for _ in range(2):
            push = sent - k * x_o - b * v_o
            x_o, v_o = x_o + v_o * T + push * T * T / (2 * m_o), v_o + push * T / m_o
        held = (force - down) / m_h
        return [x_h + v_h * 2 * T + held * 2 * T * T, v_h + held * 2 * T, x_o, v_o]

    zero, one = Fraction(0), Fraction(1)
    columns = []
    for index in (1, 2, 3):
        unit = [one if i == index else zero for i in range(4)]
        columns.append([a - c for a, c in zip(frame(unit, zero), unit, strict=True)])
    columns.append(frame([zero] * 4, one))
    solution = solve(columns, [2 * T, zero, 2 * T, zero])
    closed: Any = centralized_damping_two_samples
    assert solution[-1] / solution[0] == closed(m_o, k, b, T)
