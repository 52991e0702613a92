"""Words in ``record:`` that choose signals by what they are for."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from cosim.base.meaning import Meaning

MEASURED = frozenset(
    {
        Meaning.BOX_X,
        Meaning.BOX_Y,
        Meaning.BOX_ANGLE,
        Meaning.WALL_PENETRATION,
        Meaning.CONTACT_STATE,
        Meaning.SATURATION,
        Meaning.NORMAL_FORCE,
    }
)
"""What the measures of a run read."""
DRAWN = MEASURED | {
    Meaning.FINGER_X,
    Meaning.FINGER_Y,
    Meaning.FINGER_FORCE_X,
    Meaning.FINGER_FORCE_Y,
    Meaning.JOINT_ANGLE_1,
    Meaning.JOINT_ANGLE_2,
    Meaning.TIP_POSITION,
    Meaning.AXIS_POSITION,
    Meaning.AXIS_FORCE,
    Meaning.NODE_POSITION,
    Meaning.POINTER_X,
    Meaning.POINTER_Y,
    Meaning.POINTER_VALID,
    Meaning.POINTER_COUNT,
    Meaning.PORT_ENERGY,
}
"""What a run's pictures show, and what its measures read."""


@dataclass(frozen=True, slots=True)
class RecordPreset:
    """The signals that a word stands for, beside what ``expect`` names."""

    purpose: str
    meanings: frozenset[Meaning]
    with_packets: bool = False
    """Whether age and number of the packets that are held are among them."""


PRESETS: Mapping[str, RecordPreset] = {
    "summary": RecordPreset("measures and expectations read", MEASURED),
    "display": RecordPreset("pictures show", DRAWN, with_packets=True),
}


def named_in(targets: Iterable[str]) -> list[str]:
    """The signals in targets of expectations: ``a.x - b.x`` and ``|a.force|`` name three."""
    parts = (part.strip() for target in targets for part in re.split(r"\s-\s|\|", target))
    return list(dict.fromkeys(part for part in parts if "." in part))
