"""How a peer's intent is guessed between its packets; the C side is ``intent.h``."""

from __future__ import annotations

from collections.abc import Mapping

from fmus.shared.workstation.peers import PEERS
from fmus.shared.workstation.short_forms import real
from fmus.shared.workstation.state import pairs
from fmus.state import Kept, reals, words
from fmus.table import Group

FITTED = "fitted by 'cohaptic intent' to quick and slow reaches, docs/people.md"

PARAMETERS: Mapping[str, tuple[float, str, str]] = {
    "acceleration": (4.0, "m/s2", "Acceleration of a hand that moves, rms"),
    "decay": (0.35, "s", "Time in which an acceleration decays"),
    "drift": (7e-3, "m/s", "How fast a hand at rest drifts, rms"),
    "position_noise": (1e-5, "m", "Of the positions that packets say, rms"),
    "velocity_noise": (0.05, "m/s", "Of the velocities that they say, rms"),
    "start_rate": (3.0, "1/s", "How often a hand at rest begins to move"),
    "stop_rate": (12.0, "1/s", "How often a hand that moves stops"),
}
"""Name -> start value, unit, what it is."""

COORDINATES = 7
MODES = ("rest", "move")


def intent_group() -> Group:
    """The numbers of ``predictor: intent``."""
    return Group(
        "intent",
        tuple(
            real(
                name,
                f"{text}, for predictor 'intent' ({FITTED})",
                unit,
                start,
                minimum=0.0,
            )
            for name, (start, unit, text) in PARAMETERS.items()
        ),
    )


def intent_state() -> list[Kept]:
    """What is believed of each peer; the theory refuses the predictor by name."""
    used = "predictor>=2"
    found: list[Kept] = []
    for peer, number in pairs(PEERS, COORDINATES):
        one = f"intent[{peer}].coordinate[{number}]"
        for mode in MODES:
            found += reals((f"{one}.{mode}.mean[{i}]" for i in range(3)), "1", when=used)
            found += reals((f"{one}.{mode}.covariance[{i}]" for i in range(6)), "1", when=used)
        found += reals((f"{one}.moving",), "1", when=used)
    for peer in range(PEERS):
        found += words((f"intent[{peer}].tick", f"intent[{peer}].heard"))
    return found
