"""Whether Hermitian matrix inequalities have a solution: Newton's method along the central path.

    max t   with   Σ_k x_k E_bk − t I ⪰ 0 in every block b,   c · x = c · x₀.

Boyd and Vandenberghe 2004, chapter 11. It ends as soon as t > 0, which is proved by Cholesky
factors, or the duality gap says that no t > 0 is left. Written out for the scalings of μ, which are
few numbers in large Hermitian matrices: a general solver takes their real matrices of twice the
order, and minutes.
"""

from __future__ import annotations

import numpy as np

from cosim.theory.numerics import Complex, Real, solve

STEPS = 80
"""Newton steps, after which the answer is no."""
FASTER = 0.12
"""The barrier's weight shrinks by this once a centre is near."""


def feasible(blocks: tuple[Complex, ...], normal: Real, start: Real) -> Real | None:
    """X with Σ x_k E_bk ≻ 0 in every block, or None where none was found.

    Args:
        blocks: E, per block of shape (unknowns, n, n), Hermitian.
        normal: c, shape (unknowns,); it keeps x from growing.
        start: x₀, shape (unknowns,).
    """
    x = start.astype(np.float64)
    order = sum(one.shape[1] for one in blocks)
    lowest = min(float(np.linalg.eigvalsh(_at(one, x))[0]) for one in blocks)
    if lowest > 0.0 and _proved(blocks, x):
        return x
    t = lowest - 0.1 * max(1.0, abs(lowest))
    weight = abs(t)
    row = np.append(normal, 0.0)
    for _ in range(STEPS):
        gradient, hessian = _barrier(blocks, x, t)
        gradient[-1] -= 1.0 / weight
        step = _newton(hessian, gradient, row)
        decrement = float(np.sqrt(max(0.0, -gradient @ step)))
        length = _inside(blocks, x, t, step, 1.0 if decrement < 0.5 else 2.0)
        if decrement >= 0.5:
            # Half way to where it would leave, and never less than what Newton's method may.
            length = max(length / 2.0, 1.0 / (1.0 + decrement))
        x, t = x + length * step[:-1], t + length * step[-1]
        if t > 0.0 and _proved(blocks, x):
            return x
        if decrement < 0.3:
            # At a centre: the best t is at most t + order × weight.
            if t + 2.0 * order * weight < 0.0 or weight < 1e-9:
                return None
            weight *= FASTER
    return None


def _at(block: Complex, x: Real) -> Complex:
    return np.tensordot(x, block, axes=1)


def _barrier(blocks: tuple[Complex, ...], x: Real, t: float) -> tuple[Real, Real]:
    """Gradient and Hessian of −Σ log det(F_b(x) − t I) in (x, t)."""
    size = x.size + 1
    gradient, hessian = np.zeros(size), np.zeros((size, size))
    for block in blocks:
        n = block.shape[1]
        factor = np.linalg.cholesky(_at(block, x) - t * np.eye(n))
        inverse = np.linalg.inv(factor)
        effects = np.concatenate([block, -np.eye(n, dtype=np.complex128)[None]])
        inner = inverse @ effects @ inverse.conj().T
        gradient -= np.trace(inner, axis1=1, axis2=2).real
        flat = inner.reshape(size, -1)
        flat = np.hstack([flat.real, flat.imag])
        hessian += flat @ flat.T
    return gradient, hessian


def _newton(hessian: Real, gradient: Real, row: Real) -> Real:
    """The Newton step along which ``row`` does not change."""
    regular = hessian + 1e-13 * np.trace(hessian) / len(hessian) * np.eye(len(hessian))
    both = solve(regular, np.stack([gradient, row], axis=1))
    push, turn = both[:, 0], both[:, 1]
    return -(push - turn * (row @ push) / (row @ turn))


def _inside(blocks: tuple[Complex, ...], x: Real, t: float, step: Real, length: float) -> float:
    """The longest of ``length``, its half and so on that stays inside."""
    for _ in range(60):
        try:
            for block in blocks:
                inner = _at(block, x + length * step[:-1])
                np.linalg.cholesky(inner - (t + length * step[-1]) * np.eye(len(inner)))
        except np.linalg.LinAlgError:
            length /= 2.0
        else:
            return length
    return 0.0


def _proved(blocks: tuple[Complex, ...], x: Real) -> bool:
    try:
        for block in blocks:
            np.linalg.cholesky(_at(block, x))
    except np.linalg.LinAlgError:
        return False
    return True
