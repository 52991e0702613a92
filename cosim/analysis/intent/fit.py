"""The intent predictor's numbers, fitted to moves: the least error over all round trips."""

from __future__ import annotations

import numpy as np

from cosim.analysis.intent.compare import DELAYS, error, intent
from cosim.analysis.intent.filter import Tuning
from cosim.analysis.intent.moves import Moves

_STEPS = (1.0, 0.5, 0.25)
"""Of the logarithm of each number, one after the other."""


def fit(moves: Moves, start: Tuning | None = None) -> Tuning:
    """The tuning whose mean error over the round trips is least, by compass search.

    What is judged is the error relative to the start's at each round trip, so that the longest does
    not outweigh all others.
    """
    best = start or Tuning.default()
    scale = _errors(moves, best)
    least = 1.0
    for step in _STEPS:
        improved = True
        while improved:
            improved = False
            for number in range(len(best.names)):
                for sign in (1.0, -1.0):
                    move = np.zeros(len(best.names))
                    move[number] = sign * step
                    tried = best.scaled(move)
                    found = float(np.mean(_errors(moves, tried) / scale))
                    if found < least * (1.0 - 1e-3):
                        best, least, improved = tried, found, True
                        break
    return best


def _errors(moves: Moves, tuning: Tuning) -> np.ndarray:
    guess = intent(moves, tuning)
    return np.array([error(moves, guess, delay) for delay in DELAYS])
