"""What signals mean in records that do not say so: those of cohaptic 0.1.0.

Only a reader of such a record may ask here. Everything written since has the meaning in the file.
"""

from __future__ import annotations

import re

from cosim.base.meaning import NO_SLOT, Meaning, Slot

_FORMS: tuple[tuple[str, dict[str, Meaning]], ...] = (
    (
        r"box_pose\.(?P<what>x|y|theta)",
        {"x": Meaning.BOX_X, "y": Meaning.BOX_Y, "theta": Meaning.BOX_ANGLE},
    ),
    (r"(?P<what>wall_penetration)", {"wall_penetration": Meaning.WALL_PENETRATION}),
    (
        r"finger_(?P<finger>\d+)\.(?P<what>normal_force|contact_state|position\[[12]\])",
        {
            "normal_force": Meaning.NORMAL_FORCE,
            "contact_state": Meaning.CONTACT_STATE,
            "position[1]": Meaning.FINGER_X,
            "position[2]": Meaning.FINGER_Y,
        },
    ),
    (
        r"\w+_contact_(?P<peer>\d+)\.finger_(?P<finger>\d+)_(?P<what>normal_force|contact_state)",
        {"normal_force": Meaning.NORMAL_FORCE, "contact_state": Meaning.CONTACT_STATE},
    ),
    (
        r"(?P<what>tip_position|motor_torque)\[\d\]",
        {"tip_position": Meaning.TIP_POSITION, "motor_torque": Meaning.MOTOR_TORQUE},
    ),
    (
        r"(?P<what>position|velocity|force)",
        {
            "position": Meaning.AXIS_POSITION,
            "velocity": Meaning.AXIS_VELOCITY,
            "force": Meaning.AXIS_FORCE,
        },
    ),
)
_PATTERNS = tuple((re.compile(pattern), meanings) for pattern, meanings in _FORMS)


def old_meaning(signal: str) -> tuple[Meaning | None, Slot]:
    """What a signal of that name (``component.variable``) meant then, and whose it was."""
    variable = signal.partition(".")[2]
    for pattern, meanings in _PATTERNS:
        if match := pattern.fullmatch(variable):
            found = match.groupdict()
            numbers = {key: int(found[key]) for key in ("peer", "finger") if found.get(key)}
            return meanings[found["what"]], Slot(**numbers)
    return None, NO_SLOT
