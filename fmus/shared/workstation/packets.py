"""The members of a packet, as outputs and as inputs; the C side is ``packet.h``."""

from __future__ import annotations

from dataclasses import replace

from cosim.base.meaning import Meaning
from fmus.shared.workstation.fingers import ALL_FINGER_INPUTS, FINGERS
from fmus.shared.workstation.short_forms import output, signal
from fmus.table import ModelVariable, Terminal

_BOX = (
    ("box_x", "Box position x", "m"),
    ("box_y", "Box position y", "m"),
    ("box_theta", "Box angle", "rad"),
    ("box_vx", "Box velocity x", "m/s"),
    ("box_vy", "Box velocity y", "m/s"),
    ("box_omega", "Box angular velocity", "rad/s"),
)


_TOLD = (
    ("position", "m", (Meaning.TOLD_X, Meaning.TOLD_Y)),
    ("velocity", "m/s", (Meaning.TOLD_VELOCITY_X, Meaning.TOLD_VELOCITY_Y)),
)
_STATUS = (
    "Sum of 1 homed, 2 active, 4 fault, 8 output enabled, 16 in contact, 32 finger 1 and 64 finger "
    "2 can be touched, 128 the content is repeated by the deadband"
)


def packet_outputs(
    *, motion: bool, box: bool, force: tuple[str, ...] | None = None
) -> tuple[ModelVariable, ...]:
    """The members of a packet that a workstation sends.

    ``motion``, ``box`` and ``force`` choose what it carries; ``force`` names what the forces depend
    on. Every member depends on all that is compared, because the deadband renews all at once.
    """
    content = ALL_FINGER_INPUTS if force is None else force
    members: list[ModelVariable] = []
    for number in range(1, FINGERS + 1):
        if motion:
            members += [
                output(
                    f"finger_{number}_{quantity}",
                    f"{quantity.capitalize()} of finger {number}",
                    unit,
                    content,
                    size=2,
                    meaning=meanings,
                    finger=number,
                )
                for quantity, unit, meanings in _TOLD
            ]
        if force is not None:
            members.append(
                output(f"finger_{number}_force", f"Force on finger {number}", "N", content, size=2)
            )
    if box:
        members += [output(*entry, content) for entry in _BOX]
    ages = tuple(dict.fromkeys((*content, "finger_*.sample_age")))
    members += [
        output("source_tick", "Tick of the sender", None, meaning=Meaning.SOURCE_TICK),
        output("source_age", "Age of the content in ticks", None, ages, meaning=Meaning.SOURCE_AGE),
        output("status", _STATUS, None, ALL_FINGER_INPUTS, meaning=Meaning.SOURCE_STATUS),
    ]
    return tuple(members)


def packet_inputs(*, motion: bool, box: bool, force: bool) -> tuple[ModelVariable, ...]:
    """The members of a packet that a workstation receives."""
    members: list[ModelVariable] = []
    for number in range(1, FINGERS + 1):
        if motion:
            members += [
                signal(f"finger_{number}_position", f"Position of finger {number}", "m", size=2),
                signal(f"finger_{number}_velocity", f"Velocity of finger {number}", "m/s", size=2),
            ]
        if force:
            members.append(
                signal(f"finger_{number}_force", f"Force on finger {number}", "N", size=2)
            )
    if box:
        members += [signal(*entry) for entry in _BOX]
    members += [
        signal(
            "source_tick",
            "Tick of the sender; -1 until it is heard, and it does not count",
            None,
            start=-1,
        ),
        signal("source_age", "Age of the content in ticks when it was sent", None),
        signal("status", _STATUS, None),
    ]
    return tuple(replace(member, meaning=Meaning.PEER_STATE) for member in members)


def packet_terminal(name: str, description: str, members: tuple[ModelVariable, ...]) -> Terminal:
    """A terminal whose members are the variables of the group with the same name."""
    return Terminal(
        name=name,
        description=description,
        members={member.name: f"{name}.{member.name}" for member in members},
    )
