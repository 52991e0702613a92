"""Random cooperative loops for Hypothesis."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import strategies as st

from cosim.theory.models.mass_spring_damper import Centralized, Distributed, Model
from cosim.theory.models.timing import PathDelay, Timing

MASSES = st.floats(0.05, 2.0)
STIFFNESSES = st.floats(1.0, 5000.0)
DAMPINGS = st.floats(0.1, 20.0)
HAND_STIFFNESSES = st.one_of(st.just(0.0), st.floats(10.0, 1000.0))


def _array(draw: st.DrawFn, values: st.SearchStrategy[float], size: int) -> np.ndarray:
    return np.array(draw(st.lists(values, min_size=size, max_size=size)))


def _square(draw: st.DrawFn, values: st.SearchStrategy[float], size: int) -> np.ndarray:
    return _array(draw, values, size * size).reshape(size, size)


@st.composite
def models(draw: st.DrawFn, *, users: int | None = None) -> Model:
    """A loop of 1 to 3 users with every parameter its own."""
    damped = draw(st.booleans())
    if draw(st.booleans()):
        count = users or draw(st.integers(1, 3))
        return Centralized(
            present=(True,) * count,
            hand_mass=_array(draw, MASSES, count),
            hand_damping=_array(draw, DAMPINGS, count) if damped else np.zeros(count),
            object_mass=draw(MASSES),
            stiffness=_array(draw, STIFFNESSES, count),
            damping=_array(draw, DAMPINGS, count),
            compensation=draw(st.floats(-2.0, 2.0)),
            hand_stiffness=draw(HAND_STIFFNESSES),
        )
    count = users or draw(st.integers(2, 3))
    return Distributed(
        present=(True,) * count,
        hand_mass=_array(draw, MASSES, count),
        hand_damping=_array(draw, DAMPINGS, count) if damped else np.zeros(count),
        object_mass=_array(draw, MASSES, count),
        local_stiffness=_array(draw, STIFFNESSES, count),
        local_damping=_array(draw, DAMPINGS, count),
        remote_stiffness=_square(draw, STIFFNESSES, count),
        remote_damping=_square(draw, DAMPINGS, count),
        object_stiffness=_square(draw, STIFFNESSES, count),
        object_damping=_square(draw, DAMPINGS, count),
        compensation=_array(draw, st.floats(-2.0, 2.0), count),
        hand_stiffness=draw(HAND_STIFFNESSES),
    )


WHOLE_RATIOS = st.integers(1, 16).map(Fraction)
RATIONAL_RATIOS = st.builds(Fraction, st.integers(1, 7), st.integers(1, 4))


def timings(ratios: st.SearchStrategy[Fraction]) -> st.SearchStrategy[Timing]:
    """Round trips of n = 0..3 split at will, with up to two ticks of computation delay."""
    delays = st.integers(0, 3).flatmap(
        lambda n: st.integers(0, n).map(lambda i: PathDelay(forward=i, backward=n - i))
    )
    return st.builds(Timing, ratio=ratios, delay=delays, computation_delay=st.integers(0, 2))
