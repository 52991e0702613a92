"""Which recorded signals are the platform's: copies of the box, and fingers that touch it.

They are found by what they mean (``cosim.base.meaning``), whatever they are called.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from weakref import WeakKeyDictionary

from cosim.base.meaning import Meaning, Slot
from cosim.base.recording import Column
from cosim.record.reader import Run
from cosim.record.signals import RecordedSignal

POSE = (Meaning.BOX_X, Meaning.BOX_Y, Meaning.BOX_ANGLE)
TIP = (Meaning.FINGER_X, Meaning.FINGER_Y)


@dataclass(frozen=True, slots=True)
class Contact:
    """A finger on a copy of the box: the copy's own, or with ``slot.peer`` a remote one."""

    copy: str
    slot: Slot
    state: str
    """Signal of the contact state: 0 free, 1 moment cancellation, 2 pre-slide, 3 slide."""
    normal_force: str | None
    """Signal of the normal force (N), where it is recorded."""

    @property
    def is_own(self) -> bool:
        """Whether the finger belongs to the workstation that simulates this copy."""
        return self.slot.peer is None

    def __str__(self) -> str:
        finger = "finger" if self.slot.finger is None else f"finger {self.slot.finger}"
        peer = "" if self.is_own else f", peer {self.slot.peer}"
        return f"{self.copy}{peer} {finger}"


@dataclass(frozen=True, slots=True)
class RecordedPlatform:
    """Copies of the box, by the component that shows each, and contacts with them."""

    poses: Mapping[str, tuple[str, str, str]]
    """The signals of each copy's pose: x (m), y (m), theta (rad)."""
    contacts: tuple[Contact, ...]
    tips: Mapping[str, tuple[tuple[str, str], ...]]
    """The signals x, y (m) of the own fingers' tips, by copy."""
    depths: Mapping[str, str]
    """The signal of the depth in a wall (m), by copy."""
    saturations: tuple[str, ...] = ()
    """The signals that count ticks in which a finger was to be given more than its device can."""

    @property
    def is_there(self) -> bool:
        """Whether anything of it was recorded."""
        return bool(self.poses or self.contacts or self.depths or self.saturations)

    @property
    def copies(self) -> tuple[str, ...]:
        """Names of the components that show a pose."""
        return tuple(self.poses)


def find_platform(
    recorded: Mapping[str, RecordedSignal] | Mapping[str, Column],
) -> RecordedPlatform:
    """What of the platform is among the recorded signals; empty for another scenario."""
    found: dict[str, dict[tuple[Meaning, Slot], str]] = {}
    for name, signal in recorded.items():
        if signal.meaning is not None:
            component = found.setdefault(name.partition(".")[0], {})
            component.setdefault((signal.meaning, signal.belongs_to), name)
    poses: dict[str, tuple[str, str, str]] = {}
    tips: dict[str, tuple[tuple[str, str], ...]] = {}
    depths: dict[str, str] = {}
    contacts: list[Contact] = []
    saturations: list[str] = []
    for copy, meant in found.items():
        pose = _together(meant, POSE, Slot())
        if pose is not None:
            x, y, angle = pose
            poses[copy] = (x, y, angle)
            pairs = (_together(meant, TIP, slot) for slot in _slots(meant, Meaning.FINGER_X))
            tips[copy] = tuple((pair[0], pair[1]) for pair in pairs if pair is not None)
            if (Meaning.WALL_PENETRATION, Slot()) in meant:
                depths[copy] = meant[Meaning.WALL_PENETRATION, Slot()]
        saturations += [meant[Meaning.SATURATION, s] for s in _slots(meant, Meaning.SATURATION)]
        contacts += [
            Contact(
                copy,
                slot,
                meant[Meaning.CONTACT_STATE, slot],
                meant.get((Meaning.NORMAL_FORCE, slot)),
            )
            for slot in _slots(meant, Meaning.CONTACT_STATE)
        ]
    return RecordedPlatform(poses, tuple(contacts), tips, depths, tuple(saturations))


_FOUND: WeakKeyDictionary[Run, RecordedPlatform] = WeakKeyDictionary()


def platform_of(run: Run) -> RecordedPlatform:
    """What of the platform a run has recorded; looked for once."""
    if run not in _FOUND:
        _FOUND[run] = find_platform(run.signals)
    return _FOUND[run]


def _slots(meant: Iterable[tuple[Meaning, Slot]], meaning: Meaning) -> list[Slot]:
    return [slot for found, slot in meant if found is meaning]


def _together(
    meant: Mapping[tuple[Meaning, Slot], str], meanings: tuple[Meaning, ...], slot: Slot
) -> tuple[str, ...] | None:
    """The signals of several meanings, where all are recorded."""
    if any((meaning, slot) not in meant for meaning in meanings):
        return None
    return tuple(meant[meaning, slot] for meaning in meanings)
