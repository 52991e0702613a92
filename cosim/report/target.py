"""What an expectation looks at: a signal, the difference of two, or the length of a vector.

::

    vr_a.box_pose.y
    vr_a.box_pose.x - vr_b.box_pose.x
    |vr_a.finger_1.force|
    |vr_a.finger_1.position - vr_b.finger_1.position|

Signals of different rates are compared at the faster one's ticks, the slower one held.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.record.reader import Run
from cosim.record.signals import RecordedSignal, Values


@dataclass(frozen=True, slots=True)
class Target:
    """A difference ``plus[i] - minus[i]`` for each element i (``minus`` may be empty).

    ``is_norm`` takes the root of the sum of squares over the elements; otherwise there is one.
    """

    text: str
    plus: tuple[str, ...]
    minus: tuple[str, ...] = ()
    is_norm: bool = False

    @property
    def signals(self) -> tuple[str, ...]:
        """Every signal that is needed."""
        return self.plus + self.minus


def parse_target(text: str, recorded: Collection[str]) -> Target:
    """Resolve a target against the names of the recorded signals.

    Raises:
        InputError: a signal is not recorded, or the two sides do not match.
    """
    inner = text.strip()
    is_norm = len(inner) > 2 and inner[0] == inner[-1] == "|"
    sides = [side.strip() for side in (inner[1:-1] if is_norm else inner).split(" - ")]
    if len(sides) > 2:
        raise InputError(f"{text}: a target is one signal or the difference of two.")
    found = [_elements(side, recorded) for side in sides]
    if not is_norm and any(len(names) > 1 for names in found):
        array = max(found, key=len)
        raise InputError(f"{text}: is an array; take {array[0]}, or the length |{text}|.")
    if len({len(names) for names in found}) > 1:
        sizes = " and ".join(str(len(names)) for names in found)
        raise InputError(f"{text}: the two sides have {sizes} elements.")
    return Target(inner, found[0], found[1] if len(found) == 2 else (), is_norm)


def aligned(
    run: Run, names: Sequence[str], first: int, last: int
) -> Iterator[tuple[NDArray[np.int64], list[Values]]]:
    """Ticks, and the values of several signals at them, for ``first`` <= tick < ``last``.

    Comes piece by piece, at the rate of the fastest; a slower signal is held.
    """
    signals = [run[name] for name in names]
    group = min((signal.group for signal in signals), key=lambda group: group.period)
    covered = min(signal.group.rows * signal.group.period for signal in signals)
    start, stop = group.first_row_at(first), group.first_row_at(min(last, covered))
    for low, high in group.pieces(start, stop):
        ticks = group.ticks_of(low, high)
        yield (
            ticks,
            [
                signal[low:high] if signal.group is group else _held(signal, ticks)
                for signal in signals
            ],
        )


def blocks(
    run: Run, target: Target, first: int, last: int
) -> Iterator[tuple[NDArray[np.int64], Values]]:
    """Ticks and values of a target for ``first`` <= tick < ``last``, piece by piece."""
    for ticks, values in aligned(run, target.signals, first, last):
        yield ticks, _combine(target, values)


def _elements(name: str, recorded: Collection[str]) -> tuple[str, ...]:
    if name in recorded:
        return (name,)
    pattern = re.compile(re.escape(name) + r"\[(\d+)\]")
    matches = [match for other in recorded if (match := pattern.fullmatch(other))]
    numbered = sorted((int(match[1]), match[0]) for match in matches)
    if not numbered:
        raise InputError(
            f"{name} is not a recorded signal; record: says what is.{did_you_mean(name, recorded)}"
        )
    return tuple(element for _, element in numbered)


def _held(signal: RecordedSignal, ticks: NDArray[np.int64]) -> Values:
    rows = ticks // signal.group.period
    low, high = int(rows[0]), int(rows[-1])
    return signal[low : high + 1][rows - low]


def _combine(target: Target, held: list[Values]) -> Values:
    count = len(target.plus)
    if not target.is_norm and not target.minus:
        return held[0]
    values = [value.astype(np.float64, copy=False) for value in held]
    differences = values[:count]
    if target.minus:
        differences = [a - b for a, b in zip(differences, values[count:], strict=True)]
    if not target.is_norm:
        return differences[0]
    return np.sqrt(sum((value * value for value in differences[1:]), differences[0] ** 2))
