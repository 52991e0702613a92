"""Random numbers for channels: integers computed from a key and a counter, and nothing else.

Each draw is a hash of (stream key, packet number, purpose), so it does not depend on the order of
draws, the size of a block, the platform or the version of a library. The mixing function is the
64-bit finaliser of SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators,
OOPSLA 2014), applied to a Weyl sequence.
"""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

_GOLDEN = 0x9E3779B97F4A7C15
_MASK = 0xFFFFFFFFFFFFFFFF
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)


def stream_key(seed: int, *names: str) -> int:
    """A 64-bit key for one stream, from the scenario's seed and the stream's name."""
    text = "\x1f".join((str(seed), *names)).encode()
    return int.from_bytes(hashlib.sha256(text).digest()[:8], "little")


def draws(key: int, purpose: int, first: int, count: int) -> NDArray[np.uint64]:
    """Uniform 64-bit integers for the counters ``first`` .. ``first + count - 1``, shape (count,).

    ``purpose`` separates the several draws that one packet needs.
    """
    counters = np.arange(first + 1, first + count + 1, dtype=np.uint64)
    stream = _mix(np.array([(key + (purpose + 1) * _GOLDEN) & _MASK], dtype=np.uint64))
    return _mix(stream + counters * np.uint64(_GOLDEN))


def thresholds(probabilities: list[float]) -> NDArray[np.uint64]:
    """The top 53 bits of a draw are below threshold p with probability p; shape (n,)."""
    return np.array([round(p * 2.0**53) for p in probabilities], dtype=np.uint64)


def top_bits(values: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """The top 53 bits of each draw, to compare with ``thresholds``."""
    return values >> np.uint64(11)


def happens(
    key: int, purpose: int, probability: float, first: int, count: int
) -> NDArray[np.bool_]:
    """Whether something of this probability happens at each counter, shape (count,)."""
    if probability <= 0:
        return np.zeros(count, dtype=np.bool_)
    return top_bits(draws(key, purpose, first, count)) < thresholds([probability])[0]


def _mix(values: NDArray[np.uint64]) -> NDArray[np.uint64]:
    values = (values ^ (values >> np.uint64(30))) * _FIRST
    values = (values ^ (values >> np.uint64(27))) * _SECOND
    return values ^ (values >> np.uint64(31))
