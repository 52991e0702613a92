"""Mean-square stability under packet loss and random delay: a Markov jump linear system.

With one-frame maps M_e after the quotient by translation, the second moments
X_i = E[x xᵀ 1(mode i)] follow X_j ← Σ_i p_ij Σ_e P(e | j) M_e X_i M_eᵀ, and the loop is
mean-square stable exactly where the spectral radius of this map is below 1 (Costa, Fragoso and
Marques 2005, theorem 3.9). It maps
positive matrices to positive ones, so its spectral radius is an eigenvalue.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.chance.decay import surely_decays
from cosim.theory.chance.packets import LinkProcess, Losses, Pattern, bernoulli, join
from cosim.theory.models.assembly import assemble
from cosim.theory.models.frame import FrameAssembly
from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import Real, largest_eigenvalue_of_map, spectral_radius
from cosim.theory.stability.quotient import without_translation

DENSE_LIMIT = 400
"""Up to this many unknowns the second-moment map is formed and its eigenvalues computed."""

LARGEST_MOMENTS = 1_000_000_000
"""Bytes of the second-moment maps of all outcomes."""


@dataclass(frozen=True, slots=True)
class JumpSystem:
    """One-frame maps with the chain that chooses between them.

    Attributes:
        maps: shape (outcomes, n, n), after the quotient.
        pattern: the chain and the probabilities of the outcomes.
    """

    maps: Real
    pattern: Pattern

    def second_moment(self, moments: Real) -> Real:
        """One frame of the second moments.

        Args:
            moments: X_i, shape (modes, n, n).

        Returns:
            Shape (modes, n, n).
        """
        return self._frame()(moments)

    def _frame(self) -> Callable[[Real], Real]:
        """That map, made once for many frames."""
        transposed = np.ascontiguousarray(self.pattern.transition.T)
        where, which = np.nonzero(self.pattern.emission)
        maps = self.maps[which] * np.sqrt(self.pattern.emission[where, which])[:, None, None]
        back = np.ascontiguousarray(maps.transpose(0, 2, 1))
        first = np.flatnonzero(np.diff(where, prepend=-1))
        is_one_each = first.size == where.size

        def frame(moments: Real) -> Real:
            modes, n = moments.shape[0], moments.shape[1]
            mixed = (transposed @ moments.reshape(modes, n * n)).reshape(moments.shape)
            if is_one_each:
                return (maps @ mixed) @ back
            # The outcomes of one mode lie together.
            return np.add.reduceat((maps @ mixed[where]) @ back, first, axis=0)

        return frame

    def mean_square_radius(self) -> float:
        """ρ of the second-moment map; mean-square stable below 1. Its root compares with ρ(M)."""
        modes, n = self.pattern.transition.shape[0], self.maps.shape[1]
        size = n * (n + 1) // 2
        if modes * size <= DENSE_LIMIT:
            lifts = np.array([symmetric_square(one) for one in self.maps])
            by_mode = np.tensordot(self.pattern.emission, lifts, axes=1)
            blocks = np.einsum("ij,jab->jaib", self.pattern.transition, by_mode)
            return spectral_radius(blocks.reshape(modes * size, modes * size))
        rows, columns = np.triu_indices(n)
        frame = self._frame()

        def apply(vector: Real) -> Real:
            moments = np.empty((modes, n, n))
            moments[:, rows, columns] = moments[:, columns, rows] = vector.reshape(modes, size)
            return frame(moments)[:, rows, columns].ravel()

        start = np.tile((rows == columns).astype(np.float64), modes)
        return largest_eigenvalue_of_map(apply, start)

    def is_stable(self, edge: float = 1.0) -> bool:
        """Whether ρ of the second-moment map is below ``edge``, just below 1."""
        modes, n = self.pattern.transition.shape[0], self.maps.shape[1]
        if modes * n * (n + 1) // 2 > DENSE_LIMIT and surely_decays(self._frame(), modes, n):
            return True
        return self.mean_square_radius() < edge


def symmetric_square(matrix: Real) -> Real:
    """X ↦ M X Mᵀ on symmetric X, as a matrix over the upper triangle.

    Args:
        matrix: M, shape (n, n).

    Returns:
        Shape (n (n + 1)/2, n (n + 1)/2), rows and columns in the order of ``triu_indices``.
    """
    rows, columns = np.triu_indices(matrix.shape[0])
    one = matrix[np.ix_(rows, rows)] * matrix[np.ix_(columns, columns)]
    other = matrix[np.ix_(rows, columns)] * matrix[np.ix_(columns, rows)]
    return one + np.where(rows == columns, 0.0, 1.0)[None, :] * other


def jump_system(assembly: FrameAssembly, pattern: Pattern, *, grounded: bool = False) -> JumpSystem:
    """The one-frame maps of every outcome, on the quotient by translation.

    Coordinates are scaled so that what the links hold (N) and what moves (m) are alike in size.
    """
    maps: list[Real] = []
    for outcome in pattern.outcomes:
        frame = assembly.frame(events=outcome, depth=pattern.depth)
        scale = np.maximum(np.abs(frame.translation), 1.0)
        scaled = frame.map * (scale[None, :] / scale[:, None])
        _refuse_large(len(scaled), len(pattern.outcomes))
        maps.append(scaled if grounded else without_translation(scaled, frame.translation / scale))
    return JumpSystem(np.array(maps), pattern)


def _refuse_large(order: int, outcomes: int) -> None:
    """Refuse second moments that do not fit into memory.

    Raises:
        InputError: with the limit.
    """
    needed = 8 * outcomes * (order * (order + 1) // 2) ** 2
    if needed > LARGEST_MOMENTS:
        raise InputError(
            f"The second moments of a loop of order {order} take {needed / 1e9:.3g} GB; up to "
            f"{LARGEST_MOMENTS / 1e9:g} GB are allowed. Shorten the delay (network samples)."
        )


def link_delays(model: Model, timing: Timing) -> list[int]:
    """The fixed delay of every link of a model, in the order of its links."""
    return [link.delay for link in assemble(model, timing).links]


def mean_square_radius(
    model: Model,
    timing: Timing,
    process: Callable[[int], LinkProcess],
    losses: Losses = "independent",
) -> float:
    """The mean-square radius of a loop whose links all behave alike.

    Args:
        model: the loop.
        timing: rates and delays; a whole ratio.
        process: from a link's fixed delay to its behaviour.
        losses: whether links lose packets independently or together.

    Returns:
        ρ of the second-moment map, per frame.
    """
    system = _system(model, timing, process, losses)
    return system.mean_square_radius() if isinstance(system, JumpSystem) else system


def is_mean_square_stable(
    model: Model,
    timing: Timing,
    process: Callable[[int], LinkProcess],
    losses: Losses = "independent",
    edge: float = 1.0,
) -> bool:
    """Whether that radius is below ``edge``, just below 1: where it is, often without computing it.

    Args:
        model: the loop.
        timing: rates and delays; a whole ratio.
        process: from a link's fixed delay to its behaviour.
        losses: whether links lose packets independently or together.
        edge: of stability.
    """
    system = _system(model, timing, process, losses)
    return system.is_stable(edge) if isinstance(system, JumpSystem) else system < edge


def _system(
    model: Model, timing: Timing, process: Callable[[int], LinkProcess], losses: Losses
) -> JumpSystem | float:
    """The loop between whose maps its links choose; without links, its radius squared."""
    assembly = assemble(model, timing)
    if not assembly.links:
        return spectral_radius(without_translation_of(assembly, model)) ** 2
    pattern = join([process(link.delay) for link in assembly.links], losses)
    return jump_system(assembly, pattern, grounded=model.grounded)


def without_translation_of(assembly: FrameAssembly, model: Model) -> Real:
    """The one-frame map of a loop without links."""
    frame = assembly.frame()
    return frame.map if model.grounded else without_translation(frame.map, frame.translation)


def critical_loss(
    model: Model, timing: Timing, losses: Losses = "independent", highest: float = 0.999
) -> float | None:
    """The smallest Bernoulli loss probability at which the loop stops being mean-square stable.

    Args:
        model: the loop.
        timing: rates and delays; a whole ratio.
        losses: whether the directions lose packets independently or together.
        highest: where the search ends.

    Returns:
        The probability; 0 where the loop is unstable without loss; None where no loss up to
        ``highest`` destabilises it.
    """
    assembly = assemble(model, timing)
    if not assembly.links:
        return None
    clean = join([bernoulli(0.0, link.delay) for link in assembly.links], losses)
    system = jump_system(assembly, clean, grounded=model.grounded)

    def radius(loss: float) -> float:
        pattern = join([bernoulli(loss, link.delay) for link in assembly.links], losses)
        return JumpSystem(system.maps, pattern).mean_square_radius()

    if radius(0.0) >= 1.0 - 1e-12:
        return 0.0
    grid = np.union1d(np.linspace(0.0, highest, 26), [0.9, 0.99, highest])
    stable = 0.0
    for loss in grid[1:]:
        if radius(float(loss)) >= 1.0:
            return _bisect(radius, stable, float(loss))
        stable = float(loss)
    return None


def _bisect(radius: Callable[[float], float], stable: float, unstable: float) -> float:
    for _ in range(48):
        middle = (stable + unstable) / 2
        if radius(middle) < 1.0:
            stable = middle
        else:
            unstable = middle
    return (stable + unstable) / 2
