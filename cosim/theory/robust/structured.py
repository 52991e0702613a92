"""The structured singular value's upper bound by D–G scaling (Fan, Tits and Doyle 1991).

μ_Δ(M) ≤ the smallest β with Hermitian D ≻ 0 and G that commute with the structure and

    β² D − Mᴴ D M − j (G M − Mᴴ G) ⪰ 0:

no Δ of the structure with ‖Δ‖ < 1/β makes I − MΔ singular. A repeated real δI has a full block of D
and of G, a repeated complex one of D alone, a full complex block d I.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from cosim.theory.numerics import Complex, Real
from cosim.theory.robust.centre import feasible

Kind = Literal["real", "complex", "full"]


@dataclass(frozen=True, slots=True)
class Uncertain:
    """One block of Δ: δI of ``size`` (real or complex), or any matrix of that size (``full``).

    Of a repeated δ the first ``leading`` rows have scalings of their own and the rest share one:
    a weaker bound, for a smaller problem. None: all have.
    """

    kind: Kind
    size: int = 1
    leading: int | None = None


def upper_bound(matrix: Complex, structure: tuple[Uncertain, ...], accuracy: float = 1e-3) -> float:
    """The bound of μ, to ``accuracy`` (relative).

    Args:
        matrix: M, shape (n, n).
        structure: the blocks of Δ along its diagonal, n in all.
        accuracy: relative.

    """
    scalings = Scalings.of(structure)
    high = float(np.linalg.norm(matrix, 2))
    smallest, low = 1e-6 * high, 0.0
    while high - low > accuracy * high and high > smallest:
        # In the logarithm until there is something to hold on to.
        tried = high / 4 if low == 0.0 else (low + high) / 2
        if scalings.prove(matrix, tried):
            high = tried
        else:
            low = tried
    return high


@dataclass(frozen=True, slots=True)
class Scalings:
    """Bases of the Hermitian D and G that commute with a structure.

    Attributes:
        d: shape (k, n, n).
        g: shape (l, n, n).
    """

    d: Complex
    g: Complex

    @staticmethod
    def of(structure: tuple[Uncertain, ...]) -> Scalings:
        """The scalings that commute with a structure."""
        n = sum(block.size for block in structure)
        d: list[Complex] = []
        g: list[Complex] = []
        start = 0
        for block in structure:
            place = slice(start, start + block.size)
            if block.kind == "full":
                one = np.zeros((n, n), dtype=np.complex128)
                one[place, place] = np.eye(block.size)
                d.append(one)
            else:
                own = _of_repeated(block)
                wide = np.zeros((len(own), n, n), dtype=np.complex128)
                wide[:, place, place] = own
                d += list(wide)
                g += list(wide) if block.kind == "real" else []
            start += block.size
        return Scalings(np.array(d), np.array(g) if g else np.zeros((0, n, n), dtype=np.complex128))

    def prove(self, matrix: Complex, bound: float) -> bool:
        """Whether D and G exist at this β: found, then verified by Cholesky factors."""
        scaled = matrix / bound
        adjoint = scaled.conj().T
        inner = self.d - adjoint @ self.d @ scaled
        turned = -1j * (self.g @ scaled - adjoint @ self.g)
        positive = np.concatenate([self.d, np.zeros_like(self.g)])
        falls = np.concatenate([inner, turned])
        traces = np.concatenate([np.trace(self.d, axis1=1, axis2=2).real, np.zeros(len(self.g))])
        # D = I, G = 0 to start from.
        start = np.concatenate([self.identity, np.zeros(len(self.g))])
        return feasible((falls, positive), traces, start) is not None

    @property
    def identity(self) -> Real:
        """The coefficients of D = I, shape (k,)."""
        flat = self.d.reshape(len(self.d), -1)
        n = self.d.shape[1]
        found = np.linalg.lstsq(flat.T, np.eye(n, dtype=np.complex128).ravel(), rcond=None)[0]
        return np.asarray(found.real, dtype=np.float64)


def _of_repeated(block: Uncertain) -> Complex:
    leading = block.size if block.leading is None else min(block.leading, block.size)
    full = hermitian_basis(leading)
    own = np.zeros((len(full), block.size, block.size), dtype=np.complex128)
    own[:, :leading, :leading] = full
    if leading == block.size:
        return own
    rest = np.diag((np.arange(block.size) >= leading).astype(np.complex128))
    return np.concatenate([own, rest[None]])


def hermitian_basis(n: int) -> Complex:
    """The Hermitian matrices of order n, shape (n², n, n)."""
    rows, columns = np.triu_indices(n)
    real = np.zeros((rows.size, n, n), dtype=np.complex128)
    places = np.arange(rows.size)
    real[places, rows, columns] = 1.0
    real[places, columns, rows] = 1.0
    rows, columns = np.triu_indices(n, 1)
    imaginary = np.zeros((rows.size, n, n), dtype=np.complex128)
    places = np.arange(rows.size)
    imaginary[places, rows, columns] = 1j
    imaginary[places, columns, rows] = -1j
    return np.concatenate([real, imaginary])
