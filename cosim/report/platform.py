"""Which recorded signals are the platform's: copies of the box, and fingers that touch it.

They are recognised by the names that the workstations give them, so that a foreign FMU that uses
the same names is understood too.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

POSE = ("x", "y", "theta")
_CONTACT = re.compile(
    r"(?P<copy>[^.]+)\.(?P<finger>finger_\d+\.|(?:peer|client)_contact_\d+\.finger_\d+_)"
    r"contact_state"
)


@dataclass(frozen=True, slots=True)
class Contact:
    """A finger on a copy of the box: ``finger_1`` is the copy's own, others are remote fingers."""

    copy: str
    finger: str
    state: str
    """Signal of the contact state: 0 free, 1 moment cancellation, 2 pre-slide, 3 slide."""
    normal_force: str | None
    """Signal of the normal force (N), where it is recorded."""

    @property
    def is_own(self) -> bool:
        """Whether the finger belongs to the workstation that simulates this copy."""
        return re.fullmatch(r"finger_\d+", self.finger) is not None

    def __str__(self) -> str:
        remote = "" if self.is_own else ","
        return f"{self.copy}{remote} {self.finger.replace('_', ' ')}"


@dataclass(frozen=True, slots=True)
class Platform:
    """Copies of the box (names of components that show a pose) and contacts with them."""

    copies: tuple[str, ...]
    contacts: tuple[Contact, ...]


def find_platform(recorded: Collection[str]) -> Platform:
    """What of the platform is among the recorded signals; empty for another scenario."""
    known = set(recorded)
    copies = [
        name.removesuffix(".box_pose.x")
        for name in recorded
        if name.endswith(".box_pose.x")
        and all(f"{name.removesuffix('x')}{part}" in known for part in POSE)
    ]
    contacts: list[Contact] = []
    for name in recorded:
        if match := _CONTACT.fullmatch(name):
            force = f"{name.removesuffix('contact_state')}normal_force"
            finger = match["finger"].rstrip("._").replace("_contact_", " ").replace(".", " ")
            contacts.append(Contact(match["copy"], finger, name, force if force in known else None))
    return Platform(tuple(copies), tuple(contacts))


def pose(copy: str) -> tuple[str, str, str]:
    """The signals of a copy's pose: x (m), y (m), theta (rad)."""
    return (f"{copy}.box_pose.x", f"{copy}.box_pose.y", f"{copy}.box_pose.theta")
