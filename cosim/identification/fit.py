"""Least squares for what enters linearly, Gauss and Newton about it for what does not.

Residuals of neighbouring rows hang together, because one kernel made them, and some rows are
noisier than others. So the covariance is the one that asks neither to be otherwise: what the
residuals of whole seconds pull at the parameters, a second a vote (Liang and Zeger 1986).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cosim.base.errors import InputError
from cosim.identification.equations import Stretch, columns
from cosim.identification.five_bar import Array, FiveBar
from cosim.identification.regressor import PARAMETERS, Coefficient

SHAPES = (
    Coefficient("latency", "s", "from the tick of a command to motion in the angles"),
    Coefficient("offset_1", "rad", "what encoder 1 shows too much"),
    Coefficient("offset_2", "rad", "what encoder 2 shows too much"),
    Coefficient("gain_1", "1", "torque of motor 1 for a commanded one"),
    Coefficient("gain_2", "1", "torque of motor 2 for a commanded one"),
)
LONGEST_DELAY = 0.02
STEPS = 12
WEIGHED = (1, 3)
"""Steps before which the runs are weighed by what is left of them."""
LARGEST_CONDITION = 1e3
"""Of the columns at equal length: beyond it a direction is not seen in these runs."""
LEAST_BLOCKS = 8
NO_FIVE_BAR = (
    "no delay, offset, gain and inertia explain these runs with a five-bar of this geometry: are "
    "geometry, directions and payloads those of the device, and was nobody holding it?"
)
LENGTHS = ("proximal", "distal", "base")
_LENGTH_NUDGE = 1e-4
_NUDGES = np.array([1e-5, 1e-4, 1e-4, 1e-4, 1e-4])


@dataclass(frozen=True, slots=True, kw_only=True)
class Length:
    """By what share of itself a length of the five-bar would have to be off, all else found anew.

    ``deviation`` is the standard deviation of ``share``, a second a vote. Linear about the lengths
    that are given, so that of a wrong one the size is none to go by, but that it is not zero.
    """

    name: str
    share: float
    deviation: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """``values`` and ``covariance`` of the linear parameters, then of ``SHAPES``.

    ``hidden`` spans the directions (parameters, directions) that the runs do not show; ``freedom``
    is that of Student's distribution for intervals. ``residual`` (rows, 2) is in N.m, ``block`` the
    second of each row, unique over runs.
    """

    values: Array
    covariance: Array
    hidden: Array
    condition: float
    freedom: int
    residual: Array
    predicted: Array
    torque: Array
    block: Array
    lengths: tuple[Length, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """What is looked for: ``alike`` holds both sides' inertias equal, ``free`` marks of SHAPES."""

    alike: bool = True
    free: tuple[bool, bool, bool, bool, bool] = (True, True, True, False, False)
    friction: bool = True

    def basis(self) -> Array:
        """From what is looked for to the regressor's parameters: (parameters, unknowns)."""
        full = np.eye(len(PARAMETERS))
        if not self.friction:
            full = full[:, :5]
        if self.alike:
            full = np.delete(full, [1, 4], axis=1)
            full[1, 0] = full[4, 2] = 1.0
        return full


def fit(bar: FiveBar, found: list[Stretch], start_delay: float, choice: Choice) -> Fit:
    """The parameters that explain the rows best.

    Raises:
        InputError: the runs are too short for an interval, or nothing comes of the search.
    """
    basis, free = choice.basis(), np.flatnonzero(choice.free)
    shape = np.array([start_delay, 0.0, 0.0, 1.0, 1.0])
    problem = _Problem(bar, found, basis)
    linear = problem.solve(shape)
    for number in range(STEPS):
        if number in WEIGHED:
            problem.weigh(shape, linear)
        step = problem.newton(shape, linear, free)
        shape[free] += step[basis.shape[1] :]
        if not (
            abs(shape[0]) < LONGEST_DELAY
            and np.all(np.abs(shape[1:3]) < 0.5)
            and np.all(shape[3:] > 0)
        ):
            raise InputError(NO_FIVE_BAR)
        linear = problem.solve(shape)
        if number > WEIGHED[-1] and np.all(np.abs(step[basis.shape[1] :]) < 1e-9):
            break
    return problem.conclude(shape, linear, free)


class _Problem:
    """Residuals and their derivatives for one choice of unknowns."""

    def __init__(self, bar: FiveBar, found: list[Stretch], basis: Array) -> None:
        self._bar, self._found, self._basis = bar, found, basis
        self._weights = np.ones(sum(len(each.chosen) for each in found))
        """Of each row: one over its run's noise (N.m), once that is known."""
        blocks: list[Array] = []
        seen = 0.0
        for each in found:
            blocks.append(each.block + seen)
            seen += float(each.block.max()) + 1.0
        self.block = np.concatenate(blocks)

    def parts(self, shape: Array) -> tuple[Array, Array, Array]:
        """Torque (rows, 2), columns (rows, 2, unknowns) and known part, gains put in."""
        made = [columns(self._bar, each, shape[1:3]) for each in self._found]
        torque = np.concatenate([each.torque(shape[0]) for each in self._found])
        matrix = np.concatenate([each[0] for each in made]) @ self._basis
        known = np.concatenate([each[1] for each in made])
        weights = self._weights[:, None]
        scale = weights / shape[3:5]
        return torque * weights, matrix * scale[:, :, None], known * scale

    def weigh(self, shape: Array, linear: Array) -> None:
        """Weigh each run by its noise: the more there is to move, the more torque a count is."""
        self._weights = np.ones(len(self._weights))
        residual = self.residual(shape, linear)
        names = np.concatenate([np.full(len(x.chosen), id(x.recording)) for x in self._found])
        for each in np.unique(names):
            rows = names == each
            self._weights[rows] = 1.0 / np.sqrt(np.mean(residual[rows] ** 2))

    def solve(self, shape: Array) -> Array:
        """The linear unknowns for given others, those that are hidden at least length."""
        torque, matrix, known = self.parts(shape)
        return _scaled_solve(matrix.reshape(-1, matrix.shape[2]), (torque - known).reshape(-1))[0]

    def residual(self, shape: Array, linear: Array) -> Array:
        """What torque is more than the columns say, (rows, 2)."""
        torque, matrix, known = self.parts(shape)
        return torque - known - matrix @ linear

    def jacobian(self, shape: Array, linear: Array, free: Array) -> Array:
        """What each unknown adds to the right-hand side, (2 rows, unknowns)."""
        _, matrix, _ = self.parts(shape)
        more: list[Array] = []
        for which in free:
            ends: list[Array] = []
            for side in (1.0, -1.0):
                moved = shape.copy()
                moved[which] += side * _NUDGES[which]
                ends.append(self.residual(moved, linear))
            more.append((ends[1] - ends[0]).reshape(-1) / (2 * _NUDGES[which]))
        return np.concatenate([matrix.reshape(-1, matrix.shape[2]), *(x[:, None] for x in more)], 1)

    def newton(self, shape: Array, linear: Array, free: Array) -> Array:
        """The step of all unknowns."""
        matrix = self.jacobian(shape, linear, free)
        return _scaled_solve(matrix, self.residual(shape, linear).reshape(-1))[0]

    def conclude(self, shape: Array, linear: Array, free: Array) -> Fit:
        """Values, covariance by seconds, and what is hidden."""
        matrix, residual = self.jacobian(shape, linear, free), self.residual(shape, linear)
        _, hidden, condition, inverse = _scaled_solve(matrix, residual.reshape(-1))
        pulls = np.einsum("rju,rj->ru", matrix.reshape(*residual.shape, -1), residual)
        blocks = np.unique(self.block)
        votes = np.stack([pulls[self.block == each].sum(axis=0) for each in blocks])
        count = len(blocks)
        if count < LEAST_BLOCKS:
            raise InputError(
                f"the handle moves in {count} seconds of these runs, {LEAST_BLOCKS} are needed for "
                "an interval: run the excitation of 'cohaptic identify --plan' for longer."
            )
        spread = inverse @ (votes.T @ votes) @ inverse * count / (count - 1)
        lift = np.zeros((len(PARAMETERS) + len(SHAPES), matrix.shape[1]))
        lift[: len(PARAMETERS), : self._basis.shape[1]] = self._basis
        for at, which in enumerate(free):
            lift[len(PARAMETERS) + which, self._basis.shape[1] + at] = 1.0
        torque, columns_, known = self.parts(shape)
        return Fit(
            values=np.concatenate([self._basis @ linear, shape]),
            covariance=lift @ spread @ lift.T,
            hidden=lift @ hidden,
            condition=condition,
            freedom=count - 1,
            residual=residual / self._weights[:, None],
            predicted=(columns_ @ linear + known) / self._weights[:, None],
            torque=torque / self._weights[:, None],
            block=self.block,
            lengths=tuple(self._length(name, shape, linear, matrix, residual) for name in LENGTHS),
        )

    def _length(
        self, name: str, shape: Array, linear: Array, matrix: Array, residual: Array
    ) -> Length:
        """What is left of the residual along a length, past what other unknowns take up."""
        bar, ends = self._bar, list[Array]()
        for side in (1.0, -1.0):
            length = float(getattr(bar, name)) * (1.0 + side * _LENGTH_NUDGE)
            self._bar = replace(bar, **{name: length})
            ends.append(self.residual(shape, linear))
        self._bar = bar
        along = (ends[1] - ends[0]).reshape(-1) / (2 * _LENGTH_NUDGE)
        along -= matrix @ _scaled_solve(matrix, along)[0]
        seen = float(along @ along)
        pulls = (along * residual.reshape(-1)).reshape(residual.shape).sum(axis=1)
        votes = np.array([pulls[self.block == each].sum() for each in np.unique(self.block)])
        share = float(votes.sum()) / seen
        return Length(
            name=name, share=share, deviation=float(np.linalg.norm(votes - votes.mean())) / seen
        )


def _scaled_solve(matrix: Array, right: Array) -> tuple[Array, Array, float, Array]:
    """Least squares with columns at equal length: solution, hidden directions, condition, (A'A)^-1.

    Hidden directions are orthonormal in the scaled unknowns, shape (unknowns, directions).
    """
    lengths = np.linalg.norm(matrix, axis=0)
    lengths[lengths == 0.0] = 1.0
    left, sizes, right_vectors = np.linalg.svd(matrix / lengths, full_matrices=False)
    seen = sizes * LARGEST_CONDITION > sizes[0]
    kept = right_vectors[seen].T / sizes[seen]
    solution = kept @ (left[:, seen].T @ right) / lengths
    inverse = (kept @ kept.T) / np.outer(lengths, lengths)
    return solution, right_vectors[~seen].T, float(sizes[0] / sizes[-1]), inverse
