"""The next value of a staircase, from the values and answers until now (Levitt 1971)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cosim.study.form import StaircaseForm


def next_value(rule: StaircaseForm, past: Sequence[tuple[float, bool]]) -> float:
    """What the next trial shows.

    Args:
        rule: where it begins, how it steps, what bounds it.
        past: value and whether it was noticed, of every trial of this staircase in order.
    """
    value, direction, reversals = rule.start, 0, 0
    noticed = unnoticed = 0
    for shown, was_noticed in past:
        value = shown
        noticed, unnoticed = (noticed + 1, 0) if was_noticed else (0, unnoticed + 1)
        turn = -1 if noticed == rule.down else 1 if unnoticed == rule.up else 0
        if turn == 0:
            continue
        noticed = unnoticed = 0
        reversals += direction not in {0, turn}
        direction = turn
        value += turn * rule.steps[min(reversals, len(rule.steps) - 1)]
        # As somebody would write it: three steps of 0.1 are 0.3.
        value = min(max(float(f"{value:.15g}"), rule.least), rule.most)
    return value


def tried(rule: StaircaseForm) -> Iterable[float]:
    """Values that tell whether the place can be given any: both ends, the first, and its steps."""
    around = (rule.start + way * step for step in rule.steps for way in (-1, 1))
    inside = (value for value in around if rule.least < value < rule.most)
    return dict.fromkeys((rule.least, rule.start, rule.most, *inside))
