"""What workstations keep from one tick to the next: fingers, packets, waves, box and contacts.

The C side is ``workstation.h``, ``packet.h``, ``wave.h`` and ``world.h``.
"""

from __future__ import annotations

from collections.abc import Iterable

from fmus.shared.workstation.fingers import FINGERS
from fmus.shared.workstation.peers import PEERS
from fmus.state import Kept, KeptReal, KeptRing, reals, words

LONGEST_WINDOW = 32
NEVER = "peers>=99"
"""Nothing in the model reads it back."""
WALLS, WALL_POINTS, CORNERS, LATTICE_NODES = 4, 8, 4, 9

IDEAL_STATION: dict[str, float | int | str] = {
    "velocity_estimator": 1,
    "velocity_window": "window",
}
"""FOAW has no derivative: a finite difference stands for it."""
IDEAL_WORLD: dict[str, float | int | str] = {
    "ground_friction": 0.0,
    "ground_rotational_friction": 0.0,
}
"""Dry friction of the ground pins the box."""


def vector(path: str, unit: str, when: str = "") -> list[Kept]:
    """Both components of a vector."""
    return reals((f"{path}.x", f"{path}.y"), unit, when=when)


def planar(path: str, linear: str, angular: str, when: str = "") -> list[Kept]:
    """A pose, a velocity or a wrench."""
    return [*vector(path, linear, when), KeptReal(path=f"{path}.theta", unit=angular, when=when)]


def station_state(own: str = "own") -> list[Kept]:
    """Each finger's window of samples, last position and energy; the tick."""
    found: list[Kept] = words((f"{own}.tick",))
    for number in range(1, FINGERS + 1):
        finger = f"{own}.finger[{number - 1}]"
        used = f"fingers>={number}"
        found += [
            KeptRing(
                path=f"{finger}.samples.value",
                unit="1",
                index=f"{finger}.samples.newest",
                rows=LONGEST_WINDOW,
                width=2,
                length=LONGEST_WINDOW,
                live="velocity_window",
                backwards=True,
                when=used,
            ),
            *vector(f"{finger}.position", "m", used),
            *port_state(f"{finger}.port", f"{used}&passivity"),
            KeptReal(path=f"{finger}.work", unit="J", when=f"{used}&passivity"),
            *words((f"{finger}.saturated",)),
            *words(f"{finger}.samples.tick[{row}]" for row in range(LONGEST_WINDOW)),
            *words((f"{finger}.samples.newest", f"{finger}.samples.count")),
        ]
    return found


def port_state(path: str, when: str) -> list[Kept]:
    """Effort, place and energy of a port; only a controller reads them."""
    return [
        *planar(f"{path}.effort", "N", "N.m", when),
        *planar(f"{path}.place", "m", "rad", when),
        KeptReal(path=f"{path}.energy", unit="J", when=when),
        *words((f"{path}.open",)),
    ]


def packet_state(path: str) -> list[Kept]:
    """What was sent last; nothing reads it without a deadband."""
    found: list[Kept] = []
    units = (*(("m", "m/s"),) * 3, ("rad", "rad/s"))
    for number, (place, rate) in enumerate(units):
        motion = f"{path}.packet.motion[{number}]"
        found += vector(f"{motion}.position", place, "deadband")
        found += vector(f"{motion}.velocity", rate, "deadband")
    for number in range(2):
        found += vector(f"{path}.packet.force[{number}]", "N", "deadband")
    return [*found, *words(f"{path}.{name}" for name in ("tick", "due", "sent"))]


def wave_state(path: str, when: str) -> list[Kept]:
    """What a receiver keeps of a wave."""
    return [
        *vector(f"{path}.consumed", "N.s", when),
        *vector(f"{path}.wave", "N", when),
        *words(f"{path}.{name}" for name in ("consumed_tick", "source_tick", "heard")),
    ]


def contact_state(path: str, when: str) -> list[Kept]:
    """A contact's anchor and its mode."""
    names = ("mode", "face", "impulses", "losses", "direction")
    return [
        KeptReal(path=f"{path}.anchor", unit="m", when=when),
        *words((f"{path}.{name}" for name in names), are_modes=True),
    ]


def world_state(path: str = "environment") -> list[Kept]:
    """The box or its soft twin, and every contact."""
    soft = "environment==1"
    found = planar(f"{path}.box.pose", "m", "rad")
    found += planar(f"{path}.box.velocity", "m/s", "rad/s")
    for node in range(LATTICE_NODES):
        found += vector(f"{path}.lattice.position[{node}]", "m", soft)
        found += vector(f"{path}.lattice.velocity[{node}]", "m/s", soft)
    for finger in range(FINGERS):
        found += contact_state(f"{path}.own[{finger}]", f"fingers>={finger + 1}")
    for peer, finger in pairs(PEERS, FINGERS):
        found += contact_state(f"{path}.peer[{peer}][{finger}]", f"peers>={peer + 1}")
        found += port_state(f"{path}.peer_port[{peer}][{finger}]", NEVER)
    for peer in range(PEERS):
        found += port_state(f"{path}.coupling_port[{peer}]", NEVER)
    for wall, point in pairs(WALLS, WALL_POINTS):
        when = f"wall_{wall + 1}.enabled" + (f"&{soft}" if point >= CORNERS else "")
        found += contact_state(f"{path}.wall[{wall}][{point}]", when)
    return found


def pairs(first: int, second: int) -> Iterable[tuple[int, int]]:
    """All pairs of two indices."""
    return ((a, b) for a in range(first) for b in range(second))
