"""The variables of the pantograph: the contract that a real device has to meet as well."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.shared.mechanism.device import device_choice, device_parameters, placement_parameters
from fmus.state import KeptRing, reals, words
from fmus.table import Model, ModelVariable, Terminal

_PARAMETERS = (
    device_choice(),
    *device_parameters("GEOMETRY"),
    *device_parameters("DYNAMICS"),
    *placement_parameters(),
    ModelVariable(
        name="finger_mass",
        description="Mass of the user's finger and hand, carried at the tip (assumed: the thesis's "
        "0.1 kg is hand and device together; beside a modelled device the finger adds 0.06 kg)",
        causality="parameter",
        unit="kg",
        start=0.06,
        minimum=0.0,
    ),
    ModelVariable(
        name="initial_tip_position",
        description="Where the tip is at the start, in the world; the default suits a Quanser-like "
        "device at the origin",
        causality="parameter",
        unit="m",
        size=2,
        start=(0.0425, 0.2),
    ),
    ModelVariable(
        name="computation_delay_ticks",
        description="Communication steps between a torque command and its taking effect; 0: the "
        "torque acts from the step in which it was computed",
        causality="parameter",
        type="integer",
        start=0,
        minimum=0,
        maximum=8,
    ),
    ModelVariable(
        name="substeps",
        description="Integration steps in one communication step",
        causality="parameter",
        type="integer",
        start=8,
        minimum=1,
        maximum=1000,
    ),
    ModelVariable(
        name="encoder_offset",
        description="Joint angle at which the encoder counts zero (known and added back)",
        causality="parameter",
        unit="rad",
        size=2,
        start=0.0,
    ),
    ModelVariable(
        name="encoder_bias",
        description="Homing error: what the measured angle is off by, unknown to its reader",
        causality="parameter",
        unit="rad",
        size=2,
        start=0.0,
    ),
    ModelVariable(
        name="stop_stiffness",
        description="Stiffness of the joints' mechanical stops (assumed)",
        causality="parameter",
        unit="N.m/rad",
        start=50.0,
        minimum=0.0,
    ),
    ModelVariable(
        name="stop_damping",
        description="Damping of the joints' mechanical stops (assumed)",
        causality="parameter",
        unit="N.m.s/rad",
        start=0.05,
        minimum=0.0,
    ),
    ModelVariable(
        name="condition_limit",
        description="The run fails where the Jacobian's condition number passes this: there the "
        "five-bar is next to a singular position and its forces mean nothing",
        causality="parameter",
        unit="1",
        start=100.0,
        minimum=1.0,
    ),
)

_INPUTS = (
    ModelVariable(
        name="motor_torque",
        description="Commanded torque of joints 1 and 2",
        causality="input",
        unit="N.m",
        size=2,
        start=0.0,
        role="actuated",
        meaning=Meaning.MOTOR_TORQUE,
    ),
    ModelVariable(
        name="hand_force",
        description="Force of the user on the tip, in the world",
        causality="input",
        unit="N",
        size=2,
        start=0.0,
        role="simulation_only",
    ),
)

_OUTPUTS = (
    ModelVariable(
        name="joint_angle",
        description="Measured angle of the proximal links, quantised by the encoders",
        causality="output",
        unit="rad",
        size=2,
        role="measured",
    ),
    ModelVariable(
        name="encoder_count",
        description="Encoder counts (0 with ideal encoders)",
        causality="output",
        type="integer",
        size=2,
        role="measured",
    ),
    ModelVariable(
        name="sample_age",
        description="Ticks since the measurement was new; 0 in simulation",
        causality="output",
        type="integer",
        role="measured",
    ),
    ModelVariable(
        name="status",
        description="Sum of 1 homed, 2 active, 4 fault, 8 output enabled; 11 in simulation",
        causality="output",
        type="integer",
        role="measured",
    ),
    ModelVariable(
        name="applied_torque",
        description="Commanded torque after delay, limits and DAC: what was sent, not measured",
        causality="output",
        unit="N.m",
        size=2,
        role="derived",
        depends_on=("motor_torque",),
    ),
    ModelVariable(
        name="motor_current",
        description="Current of the motors",
        causality="output",
        unit="A",
        size=2,
        role="simulation_only",
        depends_on=("motor_torque",),
    ),
    ModelVariable(
        name="true_joint_angle",
        description="Angle of the proximal links",
        causality="output",
        unit="rad",
        size=2,
        role="simulation_only",
    ),
    ModelVariable(
        name="tip_position",
        description="Position of the tip in the world",
        causality="output",
        unit="m",
        size=2,
        meaning=Meaning.TIP_POSITION,
        role="simulation_only",
    ),
    ModelVariable(
        name="tip_velocity",
        description="Velocity of the tip in the world",
        causality="output",
        unit="m/s",
        size=2,
        role="simulation_only",
    ),
    ModelVariable(
        name="energy",
        description="Kinetic energy of device and finger",
        causality="output",
        unit="J",
        role="simulation_only",
    ),
    ModelVariable(
        name="motor_work",
        description="Work that the motors have done on the joints so far",
        causality="output",
        unit="J",
        role="simulation_only",
    ),
)

MODEL = Model(
    name="pantograph",
    description="Planar five-bar haptic device with motors, current amplifiers, DAC, encoders and "
    "the user's finger mass at the tip",
    variables=(*_PARAMETERS, *_INPUTS, *_OUTPUTS),
    work_bytes=8,
    state=(
        *reals(("motion.angle[0]", "motion.angle[1]"), "rad"),
        *reals(("motion.rate[0]", "motion.rate[1]"), "rad/s", step=1e-4),
        *reals(("current[0]", "current[1]"), "A"),
        *reals(("work",), "J"),
        KeptRing(
            path="delayed",
            unit="N.m",
            index="oldest",
            rows=8,
            width=2,
            length="computation_delay_ticks",
            live="computation_delay_ticks",
            backwards=False,
        ),
        *words(("oldest",)),
    ),
    ideal={"encoder_counts": 0, "dac_bits": 0, "coulomb_friction": 0.0},
    damped={"viscous_friction": 0.2},
    sources=("model.c", "five_bar.c", "mechanism.c", "drive.c"),
    terminals=(
        Terminal(
            name="device",
            description="What a workstation exchanges with the device",
            members={
                "joint_angle": "joint_angle",
                "sample_age": "sample_age",
                "status": "status",
                "motor_torque": "motor_torque",
            },
        ),
    ),
)
