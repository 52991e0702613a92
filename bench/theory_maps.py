"""All stability maps of chapter 5, against the loop over eigenvalues and against python-control.

    uv run --group peers python bench/theory_maps.py

The four figures at n = 0..3 are 16 maps of 201 x 201 cells. The loops are timed on a sample of
cells of Fig. 5.2 and extrapolated; every sampled cell must agree. Times are processor times.
"""

from __future__ import annotations

import argparse
import importlib
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.signal import cont2discrete

from cosim.theory.chapters.chapter_5 import DELAYS, FIGURES
from cosim.theory.models.timing import Timing
from cosim.theory.stability.map import stability_maps

T_C, N, M_H, M_O, B = 1 / 1024, 8, 0.1, 0.4, 10.0


def workstation(k_11: float, k_12: float, k_o: float) -> tuple[Any, ...]:
    """One workstation, continuous, and its sampled feedback (4.9): A, B, K, input, output."""
    A = np.array([[0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0]], dtype=float)
    forces = np.array([[0, 0], [1 / M_H, 0], [0, 0], [0, 1 / M_O]])
    own = k_12 + k_o
    feedback = np.array([[-k_11, -B, k_11, B], [k_11, B, -k_11 - own, -3 * B]])
    sent = np.array([[k_12, B, k_o, B]])
    return A, forces, feedback, np.array([[0.0], [1.0]]), sent


def closed_by_hand(k_11: float, k_12: float, k_o: float, n: int) -> np.ndarray:
    """The one-frame matrix of two workstations, as one would write it for a single point."""
    A, forces, feedback, into, sent = workstation(k_11, k_12, k_o)
    F, G, *_ = cont2discrete((A, forces, np.eye(4), np.zeros((4, 2))), T_C, method="zoh")
    tick, push = F + G @ feedback, G @ into
    frame = np.linalg.matrix_power(tick, N)
    held = sum(np.linalg.matrix_power(tick, i) @ push for i in range(N))
    there, back = n - n // 2, n // 2
    size = 8 + n
    M = np.zeros((size, size))
    M[:4, :4] = M[4:8, 4:8] = frame
    if there:
        M[4:8, 7 + there : 8 + there] = held
        M[8, :4] = sent
        for i in range(1, there):
            M[8 + i, 7 + i] = 1
    else:
        M[4:8, :4] = held @ sent
    first = 8 + there
    if back:
        M[:4, first + back - 1 : first + back] = held
        M[first, 4:8] = sent
        for i in range(1, back):
            M[first + i, first + i - 1] = 1
    else:
        M[:4, 4:8] = held @ sent
    return M


def by_eigenvalues(k_11: float, k_12: float, k_o: float, n: int) -> bool:
    values = np.abs(np.linalg.eigvals(closed_by_hand(k_11, k_12, k_o, n)))
    # The translation is the eigenvalue at 1.
    return bool(np.sort(np.delete(values, np.argmin(np.abs(values - 1))))[-1] < 1)


def by_control(control: Any) -> Callable[[float, float, float, int], bool]:
    def stable(k_11: float, k_12: float, k_o: float, n: int) -> bool:
        A, forces, feedback, into, sent = workstation(k_11, k_12, k_o)
        plant = control.ss(A, forces, np.eye(4), np.zeros((4, 2))).sample(T_C, method="zoh")
        tick = plant.A + plant.B @ feedback
        push = plant.B @ into
        frame = np.linalg.matrix_power(tick, N)
        held = sum(np.linalg.matrix_power(tick, i) @ push for i in range(N))
        one = control.ss(frame, held, sent, 0, N * T_C)
        late = control.ss(np.eye(n, k=-1), np.eye(n, 1), np.eye(1, n, n - 1), 0, N * T_C)
        loop = control.feedback(one * one * late if n else one * one, 1, sign=1)
        values = np.abs(control.poles(loop))
        return bool(np.sort(np.delete(values, np.argmin(np.abs(values - 1))))[-1] < 1)

    return stable


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=300, help="sampled cells a delay")
    cells = parser.parse_args().cells
    figures = list(FIGURES.values())
    times: list[float] = []
    for _ in range(3):
        start = time.process_time()
        maps = {
            f.number: stability_maps(f.parameters(), Timing(), *f.axes(), DELAYS) for f in figures
        }
        times.append(time.process_time() - start)
    total = sum(m.size for m in maps.values())
    ours = min(times)
    print(f"Schur-Cohn, {len(figures)} figures x {len(DELAYS)} delays, {total} cells: {ours:.3f} s")

    x, y = FIGURES["5.2"].axes()
    rng = np.random.default_rng(0)
    sample = [(int(i), int(j)) for i, j in rng.integers(201, size=(cells, 2))]
    peers: dict[str, Callable[[float, float, float, int], bool]] = {
        "eigenvalue loop": by_eigenvalues
    }
    try:
        peers["python-control"] = by_control(importlib.import_module("control"))
    except ImportError:
        print("python-control is not installed: uv run --group peers python bench/theory_maps.py")
    for name, stable in peers.items():
        start = time.process_time()
        differing = sum(
            stable(float(x.values[j]), float(y.values[i]), 1000.0, n) != maps["5.2"][place, i, j]
            for i, j in sample
            for place, n in enumerate(DELAYS)
        )
        each = (time.process_time() - start) / (cells * len(DELAYS))
        print(
            f"{name}: {each * 1e6:.0f} us a cell, {each * total:.0f} s for all, "
            f"ratio {each * total / ours:.0f}; {differing} of {cells * len(DELAYS)} cells differ"
        )


if __name__ == "__main__":
    main()
