"""The variables that the workstation models share; the C side is ``workstation.h``."""

from __future__ import annotations

from dataclasses import replace

from cosim.base.meaning import Meaning
from fmus.shared.mechanism.device import device_choice, device_parameters, placement_parameters
from fmus.table import Enumeration, Group, Item, ModelVariable, Terminal

FINGERS = 2
PEERS = 3

CONTACT_STATE = Enumeration(
    name="ContactState",
    description="State of a contact (thesis, figure 7.4)",
    items=(
        Item(name="free", value=0, description="No contact"),
        Item(
            name="moment_cancellation",
            value=1,
            description="Impulses of the largest force take the hand's momentum",
        ),
        Item(name="pre_slide", value=2, description="Sticking: springs along both directions"),
        Item(name="slide", value=3, description="Sliding under kinetic friction"),
    ),
)

VELOCITY_ESTIMATOR = Enumeration(
    name="VelocityEstimator",
    description="How the tip's velocity comes from sampled joint angles",
    items=(
        Item(
            name="foaw",
            value=0,
            description="First-order adaptive windowing on the joint angles, end fit, one quantum",
        ),
        Item(
            name="finite_difference",
            value=1,
            description="Difference of the tip position over the whole window",
        ),
    ),
)

PASSIVITY = Enumeration(
    name="Passivity",
    description="Whether the rendered force is kept passive",
    items=(
        Item(name="none", value=0, description="The force is rendered as it is"),
        Item(
            name="time_domain",
            value=1,
            description="Passivity observer and controller (Hannaford and Ryu, 2002)",
        ),
    ),
)

FORCE_CHANNEL = Enumeration(
    name="ForceChannel",
    description="What carries hand and force between a client and its server",
    items=(
        Item(name="plain", value=0, description="Position and velocity up, force down (thesis)"),
        Item(
            name="wave",
            value=1,
            description="Wave variables both ways (Niemeyer and Slotine, 1991)",
        ),
    ),
)

FINGER_INPUTS = ("{group}.joint_angle", "{group}.status", "{group}.sample_age")
"""What everything of a finger depends on directly."""

ALL_FINGER_INPUTS = tuple(path.replace("{group}", "finger_*") for path in FINGER_INPUTS)


def real(
    name: str,
    description: str,
    unit: str,
    start: float | tuple[float, ...],
    *,
    minimum: float | None = None,
    size: int | None = None,
    meaning: Meaning | None = None,
    tunable: bool = False,
) -> ModelVariable:
    """A real parameter."""
    return ModelVariable(
        name=name,
        description=description,
        causality="parameter",
        tunable=tunable,
        unit=unit,
        start=start,
        minimum=minimum,
        size=size,
        meaning=meaning,
    )


def integer(
    name: str,
    description: str,
    start: int,
    *,
    minimum: int,
    maximum: int,
    size: int | None = None,
    meaning: Meaning | None = None,
) -> ModelVariable:
    """An integer parameter."""
    return ModelVariable(
        name=name,
        description=description,
        causality="parameter",
        type="integer",
        start=start,
        minimum=minimum,
        maximum=maximum,
        size=size,
        meaning=meaning,
    )


def choice(name: str, description: str, enumeration: Enumeration, start: int = 0) -> ModelVariable:
    """An enumeration parameter."""
    return ModelVariable(
        name=name,
        description=description,
        causality="parameter",
        type="enumeration",
        enumeration=enumeration,
        start=start,
    )


def switch(
    name: str, description: str, *, start: bool = False, meaning: Meaning | None = None
) -> ModelVariable:
    """A boolean parameter."""
    return ModelVariable(
        name=name,
        description=description,
        causality="parameter",
        type="boolean",
        start=start,
        meaning=meaning,
    )


def output(
    name: str,
    description: str,
    unit: str | None,
    depends_on: tuple[str, ...] = (),
    *,
    size: int | None = None,
    meaning: Meaning | tuple[Meaning, ...] | None = None,
    finger: int | None = None,
) -> ModelVariable:
    """A real output with a unit, an integer one without."""
    return ModelVariable(
        name=name,
        description=description,
        causality="output",
        type="real" if unit else "integer",
        unit=unit,
        size=size,
        meaning=meaning,
        finger=finger,
        depends_on=depends_on,
    )


def signal(
    name: str,
    description: str,
    unit: str | None,
    *,
    start: float = 0,
    size: int | None = None,
    meaning: Meaning | tuple[Meaning, ...] | None = None,
) -> ModelVariable:
    """A real input with a unit, an integer one without."""
    return ModelVariable(
        name=name,
        description=description,
        causality="input",
        type="real" if unit else "integer",
        unit=unit,
        start=float(start) if unit else int(start),
        size=size,
        meaning=meaning,
    )


def station_parameters(*, peers: bool = True) -> tuple[ModelVariable, ...]:
    """How a workstation samples and estimates; ``peers`` adds how many others there are."""
    count = integer("peers", "Number of other workstations in use", 1, minimum=0, maximum=PEERS)
    return (
        integer("fingers", "Number of own fingers in use", 2, minimum=1, maximum=FINGERS),
        *((count,) if peers else ()),
        real(
            "sample_period",
            "Control period T_c: the period at which the model is stepped, as cohaptic sets it",
            "s",
            1 / 1024,
            minimum=0.0,
            meaning=Meaning.SAMPLE_PERIOD,
        ),
        choice(
            "velocity_estimator",
            "How the tip's velocity is estimated",
            VELOCITY_ESTIMATOR,
        ),
        integer(
            "velocity_window",
            "Longest window of the velocity estimator in samples; a finite difference uses all of "
            "it. Samples older than this are forgotten, so that the estimate restarts after a gap",
            16,
            minimum=1,
            maximum=31,
        ),
        *deadband_parameters(),
        choice("passivity", "Passivity layer on the rendered force of every own finger", PASSIVITY),
        real(
            "passivity_damping_limit",
            "Largest damping of the passivity controller: below 0.34 m/T it does not overshoot, "
            "above 2 m/T it is unstable (chosen: 75 g at 1024 Hz)",
            "N.s/m",
            20.0,
            minimum=0.0,
        ),
        real(
            "passivity_reserve",
            "Most of the user's energy that is kept to be given back; a small reserve makes the "
            "controller act sooner. 0: no limit",
            "J",
            0.0,
            minimum=0.0,
        ),
    )


def wave_parameters() -> tuple[ModelVariable, ...]:
    """How a client and its server exchange motion and force; both must agree."""
    return (
        choice("force_channel", "What carries hand and force; as at the other end", FORCE_CHANNEL),
        real(
            "wave_impedance",
            "Impedance b of the wave channel, as at the other end: small feels light in free "
            "motion, large feels hard in contact (chosen)",
            "N.s/m",
            10.0,
            minimum=0.0,
        ),
    )


def wave_members(*, sent: bool, depends_on: tuple[str, ...] = ()) -> tuple[ModelVariable, ...]:
    """The waves of a packet, as outputs or as inputs."""
    members: list[ModelVariable] = []
    for number in range(1, FINGERS + 1):
        name, text = f"finger_{number}_wave", f"Integral of the wave of finger {number}"
        if sent:
            members.append(output(name, text, "N.s", depends_on, size=2))
        else:
            members.append(signal(name, text, "N.s", size=2, meaning=Meaning.PEER_STATE))
    return tuple(members)


def deadband_parameters() -> tuple[ModelVariable, ...]:
    """What a packet need not tell because nobody would feel it."""
    return (
        integer(
            "network_ticks",
            "Control periods in a network period, for the deadband and the packet counters, as "
            "cohaptic sets it",
            8,
            minimum=1,
            maximum=1_000_000,
            meaning=Meaning.NETWORK_TICKS,
        ),
        real(
            "deadband",
            "Weber fraction by which the force that a receiver would feel may change before a "
            "packet has content again (0.1 is usual; Hinterseer et al. 2008); 0: every packet has",
            "1",
            0.0,
            minimum=0.0,
        ),
        real(
            "deadband_force",
            "Least force that the fraction is taken of: what a free hand feels (chosen)",
            "N",
            0.2,
            minimum=0.0,
        ),
        real(
            "deadband_arm",
            "Distance from the box's middle at which its torque is felt as a force (chosen)",
            "m",
            0.05,
            minimum=0.0,
        ),
        integer(
            "deadband_longest",
            "Network periods after which a packet has content even if nothing changed; packets "
            "between are keep-alives with the age of the content",
            16,
            minimum=1,
            maximum=1_000_000,
        ),
    )


def packet_counters(depends_on: tuple[str, ...] = ()) -> tuple[ModelVariable, ...]:
    """How much the deadband saves, 1 - sent / due; what is due and not sent is a keep-alive.

    ``depends_on`` adds to the fingers' inputs.
    """
    return (
        output("packets_due", "Packets so far, one each network period", None),
        output(
            "packets_sent",
            "Packets so far with content; the others are keep-alives",
            None,
            (*ALL_FINGER_INPUTS, *depends_on),
        ),
    )


def peer_inputs(peers: int = PEERS) -> tuple[ModelVariable, ...]:
    """What the link says of each of ``peers`` peers."""
    return (
        ModelVariable(
            name="peer_weight",
            description="Scales everything that comes from peer p, between 0 and 1",
            causality="input",
            unit="1",
            start=1.0,
            minimum=0.0,
            maximum=1.0,
            size=peers,
            meaning=Meaning.PEER_WEIGHT,
            each="peer",
        ),
        ModelVariable(
            name="peer_valid",
            description="False takes the weight of peer p as 0",
            causality="input",
            type="boolean",
            start=True,
            size=peers,
            meaning=Meaning.PEER_VALID,
            each="peer",
        ),
        ModelVariable(
            name="peer_age",
            description="Ticks since what peer p says was measured; 0 where the link does not say",
            causality="input",
            type="integer",
            start=0,
            minimum=0,
            size=peers,
            meaning=Meaning.PEER_AGE,
            each="peer",
        ),
    )


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


def planar(
    name: str,
    description: str,
    units: tuple[str, str],
    depends_on: tuple[str, ...] = (),
    *,
    meaning: tuple[Meaning | None, Meaning | None, Meaning | None] = (None, None, None),
) -> Group:
    """A pose, velocity or wrench of the plane as an output group {x, y, theta}."""
    return Group(
        name,
        (
            output("x", f"{description}, x", units[0], depends_on, meaning=meaning[0]),
            output("y", f"{description}, y", units[0], depends_on, meaning=meaning[1]),
            output("theta", f"{description}, about z", units[1], depends_on, meaning=meaning[2]),
        ),
    )


POSE = ("m", "rad")
VELOCITY = ("m/s", "rad/s")
WRENCH = ("N", "N.m")
BOX_POSE = (Meaning.BOX_X, Meaning.BOX_Y, Meaning.BOX_ANGLE)

_BOX = (
    ("box_x", "Box position x", "m"),
    ("box_y", "Box position y", "m"),
    ("box_theta", "Box angle", "rad"),
    ("box_vx", "Box velocity x", "m/s"),
    ("box_vy", "Box velocity y", "m/s"),
    ("box_omega", "Box angular velocity", "rad/s"),
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
                )
                for quantity, unit in (("position", "m"), ("velocity", "m/s"))
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


def peer_contact_outputs(depends_on: tuple[str, ...], who: str) -> tuple[ModelVariable, ...]:
    """The contacts of another workstation's fingers with the box that is simulated here."""
    members: list[ModelVariable] = []
    for number in range(1, FINGERS + 1):
        members += [
            output(
                f"finger_{number}_normal_force",
                f"Normal force of the {who}'s finger {number} on this box",
                "N",
                depends_on,
                meaning=Meaning.NORMAL_FORCE,
                finger=number,
            ),
            ModelVariable(
                name=f"finger_{number}_contact_state",
                description=f"State of the {who}'s finger {number} on this box",
                causality="output",
                type="enumeration",
                enumeration=CONTACT_STATE,
                meaning=Meaning.CONTACT_STATE,
                finger=number,
                depends_on=depends_on,
            ),
            output(
                f"finger_{number}_contact_losses",
                f"How often the contact of the {who}'s finger {number} has ended",
                None,
                depends_on,
            ),
            output(
                f"finger_{number}_energy",
                f"Energy that the {who}'s finger {number} has put into this box",
                "J",
                depends_on,
                meaning=Meaning.PORT_ENERGY,
                finger=number,
            ),
        ]
    members.append(
        output(
            "coupling_energy",
            f"Energy that the {who}'s copy of the box has put into this one",
            "J",
            depends_on,
        )
    )
    return tuple(members)


def packet_terminal(name: str, description: str, members: tuple[ModelVariable, ...]) -> Terminal:
    """A terminal whose members are the variables of the group with the same name."""
    return Terminal(
        name=name,
        description=description,
        members={member.name: f"{name}.{member.name}" for member in members},
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
