"""Hold, linear and intent beside each other: how far each is from where the hand then was."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.intent.filter import Tuning, beliefs
from cosim.analysis.intent.moves import Moves

Real = NDArray[np.float64]
DELAYS = (2, 3, 4, 5, 6)
"""Round trips, in network samples."""
SETTLED = 8
"""Packets that are not judged, because the filter has heard too little."""

Guess = Callable[[float], Real]
"""From a time ahead of each packet (s) to the positions then, shape (packets, tracks)."""


def errors(moves: Moves, tuning: Tuning | None = None) -> dict[str, dict[int, float]]:
    """Root mean square of the error in m: predictor -> round trip in samples -> error.

    Args:
        moves: what hands did.
        tuning: of the intent predictor, which is left out without.
    """
    position, velocity = moves.position[:: moves.ratio], moves.velocity[:: moves.ratio]
    guesses: dict[str, Guess] = {
        "hold": lambda _: position,
        "linear": lambda time: position + time * velocity,
    }
    if tuning is not None:
        guesses["intent"] = intent(moves, tuning)
    return {
        name: {delay: error(moves, guess, delay) for delay in DELAYS}
        for name, guess in guesses.items()
    }


def intent(moves: Moves, tuning: Tuning) -> Guess:
    """The intent predictor as a guess."""
    position, velocity = moves.position[:: moves.ratio], moves.velocity[:: moves.ratio]
    heard = beliefs(tuning, position, velocity, moves.period * moves.ratio)
    return lambda time: heard.ahead(tuning, time)[0]


def error(moves: Moves, guess: Guess, delay: int) -> float:
    """The error at a round trip of ``delay`` samples, m rms, over both ways and a sample's ticks.

    A packet is used from its delay on, ⌈n/2⌉ samples one way and ⌊n/2⌋ the other, until the next
    one comes a sample later.
    """
    total, count = 0.0, 0
    for way in (-(-delay // 2), delay // 2):
        for tick in range(moves.ratio):
            ahead = way * moves.ratio + tick
            truth = moves.position[ahead :: moves.ratio]
            judged = slice(SETTLED, len(truth))
            wrong = guess(ahead * moves.period)[: len(truth)][judged] - truth[judged]
            total += float(np.sum(wrong**2))
            count += wrong.size
    return float(np.sqrt(total / count))
