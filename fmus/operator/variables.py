"""The operator: an emulated user's finger, planar, pulled along a trajectory by hand impedance."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.operator.hands import CUSTOM_GRIP, GRIPPED, HANDS
from fmus.state import Kept, reals, words
from fmus.table import Causality, Enumeration, Item, Model, ModelVariable

VIA_POINTS = 16
GRIP = f"impedance>={GRIPPED}"
HANDLESS = (0.0,) * len(HANDS[0].row)
"""Of what is given."""
TRACKED = "trajectory>=4"
"""Where a tracked or given reference is read."""

IMPEDANCE = Enumeration(
    name="operator_impedance",
    description="How stiffly the user holds on to the reference",
    items=(
        Item(name="custom", value=0, description="stiffness and damping as given; 0: force only"),
        *(
            Item(name=hand.name, value=number, description=hand.description)
            for number, hand in enumerate(HANDS, start=1)
        ),
        Item(
            name="custom_grip",
            value=CUSTOM_GRIP,
            description="stiffness and damping of an arm of hand_mass behind grip_stiffness and "
            "grip_damping, as given",
        ),
    ),
)

TRAJECTORY = Enumeration(
    name="operator_trajectory",
    description="How the reference moves",
    items=(
        Item(name="hold", value=0, description="Stays at initial_position"),
        Item(name="sine", value=1, description="A sine on each axis around initial_position"),
        Item(name="minimum_jerk", value=2, description="Minimum jerk from via point to via point"),
        Item(name="recorded", value=3, description="Samples from a file"),
        Item(
            name="tracked",
            value=4,
            description="Tracks target_position, a person's hand; until that is first valid, the "
            "emulated user along the via points",
        ),
        Item(
            name="given",
            value=5,
            description="Is target_position itself; its velocity is the difference over a step",
        ),
    ),
)

FORCE_MODE = Enumeration(
    name="operator_force_mode",
    description="What force the user wants to exert on one axis",
    items=(
        Item(name="none", value=0, description="No force"),
        Item(name="constant", value=1, description="The amplitude, always"),
        Item(name="step", value=2, description="The amplitude from force_start_time on"),
        Item(name="sine", value=3, description="amplitude sin(frequency t + phase)"),
    ),
)


def _pair(
    name: str,
    description: str,
    unit: str,
    causality: Causality = "parameter",
    *,
    tunable: bool = False,
) -> ModelVariable:
    settable = causality in {"parameter", "input"}
    return ModelVariable(
        name=name,
        description=description,
        causality=causality,
        tunable=tunable,
        unit=unit,
        size=2,
        start=0.0 if settable else None,
    )


def _reference(name: str, description: str, unit: str) -> ModelVariable:
    return ModelVariable(
        name=f"reference_{name}",
        description=description,
        causality="output",
        unit=unit,
        size=2,
        depends_on=("target_position",),
    )


def _number(name: str, description: str, unit: str, start: float = 0.0) -> ModelVariable:
    return ModelVariable(
        name=name, description=description, causality="parameter", unit=unit, start=start
    )


def _via(name: str, description: str, unit: str) -> ModelVariable:
    return ModelVariable(
        name=name,
        description=description,
        causality="parameter",
        unit=unit,
        size=VIA_POINTS,
        start=0.0,
    )


def _kept(unit: str, *names: str) -> list[Kept]:
    paths = [f"tracking.{name}[{axis}]" for name in names for axis in range(2)]
    return reals(paths, unit, when=TRACKED)


MODEL = Model(
    name="operator",
    description="Emulated user: force, and a hand impedance along a planar trajectory",
    sources=("model.c", "tracking.c", "waveform.c"),
    state_ends_in_table=True,
    tables={"operator_hands": (HANDLESS, *(hand.row for hand in HANDS), HANDLESS)},
    state=(
        *words(("time", *(f"tracking.{name}" for name in ("sample_time", "interval", "silence")))),
        *words(("tracking.count",)),
        *words(("tracking.presence",), are_modes=True),
        *_kept("m", "position", "sample"),
        *_kept("m/s", "velocity", "sample_velocity"),
        *reals(("tracking.weight",), "1", when=TRACKED),
        *reals((f"grip.position[{axis}]" for axis in range(2)), "m", when=GRIP),
        *reals((f"grip.velocity[{axis}]" for axis in range(2)), "m/s", when=GRIP),
        *words(("grip.held",), are_modes=True),
    ),
    variables=(
        _pair("position", "Position of the finger, world frame", "m", "input"),
        _pair("velocity", "Velocity of the finger, world frame", "m/s", "input"),
        _pair("target_position", "Where a person wants the finger, world frame", "m", "input"),
        ModelVariable(
            name="target_valid",
            description="Whether a person is there: target_position counts",
            causality="input",
            type="boolean",
            start=False,
        ),
        ModelVariable(
            name="target_count",
            description="Number of the sample in target_position; another number is another sample",
            causality="input",
            type="integer",
            start=0,
        ),
        ModelVariable(
            name="target_age",
            description="Time since that sample was taken",
            causality="input",
            unit="s",
            start=0.0,
        ),
        ModelVariable(
            name="force",
            description="Force of the user on the finger, world frame",
            causality="output",
            unit="N",
            size=2,
            depends_on=("position", "velocity", "target_position"),
        ),
        _reference("position", "Where the user wants the finger to be", "m"),
        _reference("velocity", "How fast the user wants it to move", "m/s"),
        _pair("force_command", "Force that the user wants to exert", "N", "output"),
        ModelVariable(
            name="impedance",
            description="How stiffly the user holds on to the reference",
            causality="parameter",
            tunable=True,
            type="enumeration",
            enumeration=IMPEDANCE,
            start=2,
        ),
        ModelVariable(
            name="stiffness",
            description="Stiffness of the hand on each axis where impedance is custom, custom_grip",
            causality="parameter",
            tunable=True,
            unit="N/m",
            size=2,
            start=0.0,
            minimum=0.0,
        ),
        ModelVariable(
            name="damping",
            description="Damping of the hand on each axis where impedance is custom, custom_grip",
            causality="parameter",
            tunable=True,
            unit="N.s/m",
            size=2,
            start=0.0,
            minimum=0.0,
        ),
        _number("hand_mass", "Mass behind the grip of custom_grip (assumed)", "kg", 0.5),
        _number("grip_stiffness", "Stiffness of the grip of custom_grip (assumed)", "N/m", 600.0),
        _number("grip_damping", "Damping of the grip of custom_grip (assumed)", "N.s/m", 4.5),
        ModelVariable(
            name="trajectory",
            description="How the reference moves",
            causality="parameter",
            type="enumeration",
            enumeration=TRAJECTORY,
            start=0,
        ),
        _pair("initial_position", "Where the reference starts, world frame", "m"),
        _number("trajectory_start_time", "When the reference begins to move", "s"),
        _pair("sine_amplitude", "Amplitude of the reference on each axis", "m"),
        _pair("sine_frequency", "Its angular frequency", "rad/s"),
        _pair("sine_phase", "Its phase at trajectory_start_time", "rad"),
        ModelVariable(
            name="via_count",
            description="Number of via points of a minimum jerk trajectory",
            causality="parameter",
            type="integer",
            start=0,
            minimum=0,
            maximum=VIA_POINTS,
        ),
        _via("via_time", "When each via point is reached", "s"),
        _via("via_x", "Where it is, x", "m"),
        _via("via_y", "Where it is, y", "m"),
        _number("tracking_frequency", "Of the filter that tracks a target", "rad/s", 75.4),
        _number("tracking_speed", "Largest speed of the tracking reference", "m/s", 1.0),
        _number(
            "target_hold_time",
            "How long a target that is not valid any more is held; then the hand lets go",
            "s",
            0.5,
        ),
        ModelVariable(
            name="trajectory_file",
            description="Text file with a time (s), x and y (m) in each line",
            causality="parameter",
            type="string",
            start="",
            meaning=Meaning.FILE,
        ),
        ModelVariable(
            name="force_mode",
            description="What force the user wants to exert on each axis",
            causality="parameter",
            type="enumeration",
            enumeration=FORCE_MODE,
            size=2,
            start=0,
        ),
        _pair("force_amplitude", "Its size", "N", tunable=True),
        _pair("force_frequency", "Angular frequency of a sine", "rad/s"),
        _pair("force_phase", "Phase of a sine at its start", "rad"),
        _pair("force_start_time", "When a step or sine begins", "s"),
        _pair("force_duration", "How long it lasts; 0: without end", "s"),
        ModelVariable(
            name="force_rectify",
            description="Whether the user only pushes: negative forces become zero",
            causality="parameter",
            type="boolean",
            size=2,
            start=False,
        ),
    ),
)
