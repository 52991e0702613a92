"""The variables of the box, its walls and its couplings; the C side is ``environment.h``."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.shared.workstation.choices import CONTACT_STATE
from fmus.shared.workstation.fingers import FINGER_INPUTS
from fmus.shared.workstation.short_forms import (
    BOX_POSE,
    POSE,
    VELOCITY,
    WRENCH,
    choice,
    integer,
    output,
    planar,
    real,
    switch,
)
from fmus.shared.world.intent import intent_group
from fmus.table import Enumeration, Group, Item, ModelVariable

INTEGRATION = Enumeration(
    name="Integration",
    description="How the box's pose follows its velocity over a control period",
    items=(
        Item(
            name="semi_implicit_euler",
            value=0,
            description="The new velocity moves the box (thesis, section 7.2.3)",
        ),
        Item(name="explicit_euler", value=1, description="The old velocity moves the box"),
        Item(
            name="zero_order_hold",
            value=2,
            description="The mean of both: exact for a force that is held over the period",
        ),
    ),
)


ENVIRONMENT = Enumeration(
    name="Environment",
    description="The object that the users hold",
    items=(
        Item(name="box", value=0, description="A rigid square (thesis, chapter 7)"),
        Item(
            name="mass_spring",
            value=1,
            description="A soft square: 3 x 3 masses with springs along edges and diagonals",
        ),
    ),
)


PREDICTOR = Enumeration(
    name="Predictor",
    description="Where a peer is taken to be between its packets",
    items=(
        Item(name="hold_last", value=0, description="Where it last said it was"),
        Item(name="linear", value=1, description="Moved on with its last velocity for its age"),
        Item(
            name="intent",
            value=2,
            description="Moved on as a hand that rests or moves, whichever its packets speak for",
        ),
    ),
)


def box_parameters() -> tuple[ModelVariable | Group, ...]:
    """The box, the ground and the integration."""
    return (
        choice("environment", "The object that the users hold", ENVIRONMENT),
        real("soft_stiffness", "Stiffness of the soft square's springs (chosen)", "N/m", 800.0),
        real("soft_damping", "Damping of the soft square's springs (chosen)", "N.s/m", 0.5),
        real("mass", "Mass of the box (thesis, chapter 5)", "kg", 0.4),
        real(
            "inertia", "Inertia of the box; that of a uniform square of the side", "kg.m2", 6.7e-4
        ),
        real("side", "Side of the square box (chosen)", "m", 0.1, meaning=Meaning.BOX_SIDE),
        real("gravity", "Gravity, which presses the box to the ground", "m/s2", 9.81),
        real(
            "ground_friction",
            "Coulomb friction between box and ground (thesis 8.1)",
            "1",
            0.05,
            minimum=0.0,
        ),
        real(
            "ground_rotational_friction",
            "Coulomb friction in rotation (thesis 8.1), read as a coefficient at 0.383 of the "
            "side, the mean distance of a square's area from its centre",
            "1",
            0.15,
            minimum=0.0,
        ),
        choice("integration", "Integration of the box's pose", INTEGRATION),
        Group(
            "initial_box_pose",
            (
                real("x", "Position of the box at the start, x", "m", 0.0),
                real("y", "Position of the box at the start, y", "m", 0.0),
                real("theta", "Angle of the box at the start", "rad", 0.0),
            ),
        ),
    )


def wall_group() -> Group:
    """Up to four half-planes that the box's corners touch."""
    source = "thesis 8.2; each touching corner has its own, so a flat face has twice this"
    return Group(
        "wall",
        (
            switch("enabled", "Whether there is this wall", meaning=Meaning.WALL_ENABLED),
            real("point_x", "A point on the wall, x", "m", 0.0, meaning=Meaning.WALL_POINT_X),
            real("point_y", "A point on the wall, y", "m", 0.0, meaning=Meaning.WALL_POINT_Y),
            *(
                real(
                    f"normal_{axis}",
                    f"Normal of the wall into the free half-plane, {axis}",
                    "1",
                    start,
                    meaning=meaning,
                )
                for axis, start, meaning in (
                    ("x", 0.0, Meaning.WALL_NORMAL_X),
                    ("y", 1.0, Meaning.WALL_NORMAL_Y),
                )
            ),
            real("normal_stiffness", f"k_Nw ({source})", "N/m", 4000.0, minimum=0.0),
            real("normal_damping", f"b_Nw ({source})", "N.s/m", 30.0, minimum=0.0),
            real("tangential_stiffness", f"k_Tw ({source})", "N/m", 7000.0, minimum=0.0),
            real("tangential_damping", f"b_Tw ({source})", "N.s/m", 50.0, minimum=0.0),
            real("friction", "Friction of the box on the wall (chosen)", "1", 0.6, minimum=0.0),
        ),
        count=4,
    )


def peer_parameters() -> tuple[ModelVariable | Group, ...]:
    """How peers are read."""
    return (
        choice(
            "predictor",
            "Where a peer is between its packets",
            PREDICTOR,
            meaning=Meaning.PREDICTOR,
        ),
        integer(
            "prediction_limit",
            "Longest time that the predictor looks ahead, in ticks",
            64,
            minimum=0,
            maximum=1_000_000,
        ),
        intent_group(),
    )


def finger_contact_outputs() -> tuple[ModelVariable, ...]:
    """What the contact machine says of an own finger."""
    return (
        output(
            "normal_force",
            "Normal force of the contact, before max_force",
            "N",
            FINGER_INPUTS,
            meaning=Meaning.NORMAL_FORCE,
        ),
        output(
            "tangential_force",
            "Tangential force of the contact, before max_force",
            "N",
            FINGER_INPUTS,
        ),
        ModelVariable(
            name="contact_state",
            description="State of the contact with the box",
            causality="output",
            type="enumeration",
            enumeration=CONTACT_STATE,
            meaning=Meaning.CONTACT_STATE,
            depends_on=FINGER_INPUTS,
        ),
        output(
            "contact_face",
            "Face of the box that is touched: 0 none, 1 +x, 2 +y, 3 -x, 4 -y",
            None,
            FINGER_INPUTS,
        ),
        output("contact_losses", "How often the contact has ended", None, FINGER_INPUTS),
    )


def environment_outputs(peer_inputs: tuple[str, ...]) -> tuple[ModelVariable | Group, ...]:
    """The box and the wrenches on it; ``peer_inputs`` are the inputs that carry the peers."""
    own = tuple(i.replace("{group}", "finger_*") for i in FINGER_INPUTS)
    return (
        planar("box_pose", "Pose of the box", POSE, meaning=BOX_POSE),
        planar("box_velocity", "Velocity of the box", VELOCITY),
        planar("finger_wrench", "Wrench of the own fingers on the box", WRENCH, own),
        planar("wall_wrench", "Wrench of the walls on the box", WRENCH),
        planar(
            "coupling_wrench",
            "Wrench on the box of all that comes from peers, their fingers and K_o, B_o",
            WRENCH,
            peer_inputs,
        ),
        output(
            "wall_penetration",
            "Depth of the deepest corner in a wall",
            "m",
            meaning=Meaning.WALL_PENETRATION,
        ),
        output("box_energy", "Kinetic energy of the box's motion as a whole", "J"),
        output(
            "node_position",
            "Positions (x, y) of 3 x 3 points of the object, row by row from its lower left corner",
            "m",
            size=18,
            meaning=Meaning.NODE_POSITION,
        ),
    )
