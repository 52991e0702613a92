"""An own finger of a workstation, and its side of the connection to its device."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.shared.mechanism.device import device_choice, device_parameters, placement_parameters
from fmus.shared.workstation.short_forms import output, real, signal, switch
from fmus.table import Group, ModelVariable, Terminal

FINGERS = 2


FINGER_INPUTS = ("{group}.joint_angle", "{group}.status", "{group}.sample_age")
"""What everything of a finger depends on directly."""


ALL_FINGER_INPUTS = tuple(path.replace("{group}", "finger_*") for path in FINGER_INPUTS)


def finger_group(force_depends_on: tuple[str, ...], *extra: ModelVariable) -> Group:
    """An own finger; ``force_depends_on`` adds to the finger's own inputs."""
    rendered = (*FINGER_INPUTS, *force_depends_on)
    return Group(
        "finger",
        (
            device_choice("Preset of the finger's device"),
            *device_parameters("GEOMETRY"),
            *placement_parameters(),
            real(
                "max_force",
                "Largest force on the finger, also of the moment-cancelling impulses (assumed)",
                "N",
                2.5,
                minimum=0.0,
                meaning=Meaning.FORCE_LIMIT,
            ),
            signal(
                "joint_angle",
                "Measured joint angles of the device",
                "rad",
                size=2,
                meaning=(Meaning.JOINT_ANGLE_1, Meaning.JOINT_ANGLE_2),
            ),
            signal(
                "status",
                "Sum of 1 homed, 2 active, 4 fault, 8 output enabled; forces only while homed, "
                "active and without fault",
                None,
                start=11,
            ),
            signal("sample_age", "Ticks since the joint angles were measured", None),
            signal("device_work", "Work that the device's motors have done so far", "J"),
            switch(
                "device_reports_work",
                "Whether device_work is what the energy is observed by: behind an amplifier's lag "
                "a torque is not held, and what was commanded is not what did the work",
            ),
            output("motor_torque", "Torques that render the force", "N.m", rendered, size=2),
            output(
                "position",
                "Tip position in the world",
                "m",
                FINGER_INPUTS,
                size=2,
                meaning=(Meaning.FINGER_X, Meaning.FINGER_Y),
            ),
            output("velocity", "Estimated tip velocity in the world", "m/s", FINGER_INPUTS, size=2),
            output(
                "force",
                "Rendered force on the finger, world",
                "N",
                rendered,
                size=2,
                meaning=(Meaning.FINGER_FORCE_X, Meaning.FINGER_FORCE_Y),
            ),
            output(
                "observed_energy",
                "Energy that the user has put into what is rendered: minus the sum of what was "
                "held times how far the finger went",
                "J",
                rendered,
                meaning=Meaning.PORT_ENERGY,
            ),
            output(
                "saturated_ticks",
                "Ticks in which more force was wanted than max_force",
                None,
                meaning=Meaning.SATURATION,
            ),
            *extra,
        ),
        count=FINGERS,
        numbers="finger",
    )


def finger_terminals() -> tuple[Terminal, ...]:
    """Each finger's side of the connection to its device."""
    return tuple(
        Terminal(
            name=f"finger_{number}",
            description=f"What finger {number} exchanges with its device",
            members={
                member: f"finger_{number}.{member}"
                for member in ("joint_angle", "sample_age", "status", "motor_torque")
            },
        )
        for number in range(1, FINGERS + 1)
    )
