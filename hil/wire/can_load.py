"""How much of a CAN bus's time frames take; a bus that cannot carry a scenario is refused."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cosim.base.errors import InputError

BITRATE = 1_000_000
LARGEST_LOAD = 0.80
"""A bus that is fuller than this without stuffing, or full with it, cannot keep a deadline."""
_FRAME_BITS = 47
"""A classic data frame of 11-bit identifier without data: 44 bits and 3 between frames."""
_STUFFED_BITS = 34
"""Those of them that bit stuffing applies to (ISO 11898-1)."""


def frame_bits(size: int, *, stuffed: bool = False) -> int:
    """Bits of a classic frame with ``size`` data bytes; ``stuffed`` adds the worst case."""
    return _FRAME_BITS + 8 * size + ((_STUFFED_BITS + 8 * size - 1) // 4 if stuffed else 0)


@dataclass(frozen=True, slots=True)
class Load:
    """Share of a bus's time, without and with worst-case bit stuffing."""

    plain: float
    worst: float


def bus_load(sizes: Iterable[int], rate: float, bitrate: float = BITRATE) -> Load:
    """Load of the frames of one tick (data sizes in bytes) at a tick rate (Hz)."""
    frames = list(sizes)
    return Load(
        plain=sum(frame_bits(size) for size in frames) * rate / bitrate,
        worst=sum(frame_bits(size, stuffed=True) for size in frames) * rate / bitrate,
    )


def refuse_overload(name: str, sizes: Iterable[int], rate: float, bitrate: float) -> Load:
    """The load of a bus.

    Raises:
        InputError: the bus cannot carry it.
    """
    load = bus_load(sizes, rate, bitrate)
    if load.plain > LARGEST_LOAD or load.worst > 1.0:
        raise InputError(
            f"the CAN bus {name} cannot carry this: {load.plain:.1%} of its time at "
            f"{rate:g} Hz and {bitrate / 1e6:g} Mbit/s ({load.worst:.1%} with worst-case bit "
            f"stuffing), at most {LARGEST_LOAD:.0%} is sound; use a second bus, or a lower rate"
        )
    return load
