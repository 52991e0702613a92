"""Free motion and turning, section 8.2: what users feel of the network."""

from __future__ import annotations

from cosim.thesis.claims.statement import Evidence, Statement, ablation, both_copies, server

MOTION: tuple[Statement, ...] = (
    Statement(
        "ideal-force",
        "8.2",
        "Ideally the forces on the object add up to the inertial force of its motion; the local "
        "user of the centralized controller comes to it.",
        (Evidence("free_motion_local", "local", "net force, inertial force 0.080 N"),),
        ablations=(ablation("free_motion_local", "local", "twice the mass", *server(mass=0.8)),),
    ),
    Statement(
        "uncompensated-force",
        "8.2",
        "Uncompensated, the distributed user has to apply a noticeably larger force for the same "
        "motion, by the damping that the network adds.",
        (Evidence("free_motion", "uncompensated", "net force, predicted 0.347 N at n = 1"),),
        ablations=(
            ablation(
                "free_motion", "uncompensated", "compensated", *both_copies(compensation="auto")
            ),
        ),
    ),
    Statement(
        "compensated-force",
        "8.2",
        "Negative damping from the analysis improves the response significantly.",
        (
            Evidence("free_motion_compensated", "compensated", "net force, predicted 0.163 N"),
            Evidence("free_motion_printed", "printed", "with the printed -0.88 N·s/m"),
        ),
        "The added damping is gone; what remains above 0.080 N is inertia: two copies of the box "
        "are moved, each with the whole mass. The printed -0.88 N·s/m is half of the null at n = 1 "
        "for our couplers.",
        ablations=(
            ablation(
                "free_motion_compensated",
                "compensated",
                "uncompensated",
                *both_copies(compensation="~"),
            ),
            ablation(
                "free_motion_printed",
                "printed",
                "uncompensated",
                *(f"components.vr_{w}.parameters.compensation.y=0" for w in "ab"),
            ),
        ),
    ),
    Statement(
        "friction-of-each-copy",
        "",
        "Ours, not the thesis's: on the table of section 8.1 compensation improves the response, "
        "too.",
        (
            Evidence("free_motion_ground", "ground", "net force without"),
            Evidence("free_motion_ground_printed", "ground", "with the printed -0.88 N·s/m"),
            Evidence("free_motion_ground_compensated", "ground", "with the null at n = 1"),
        ),
        "A finding: each copy of the box brings its own 0.05 m g = 0.196 N, so that two users work "
        "against twice the friction of one box, and no compensation of damping takes that away.",
        ablations=(
            ablation(
                "free_motion_ground",
                "ground",
                "no friction on the second copy",
                "components.vr_b.parameters.ground_friction=0",
            ),
            ablation(
                "free_motion_ground_printed",
                "ground",
                "uncompensated",
                *both_copies(**{"compensation.y": 0}),
            ),
            ablation(
                "free_motion_ground_compensated",
                "ground",
                "uncompensated",
                *both_copies(compensation="~"),
            ),
        ),
    ),
    Statement(
        "turning",
        "8.2",
        "The network adds damping to rotation, too, and -0.025 N·m·s/rad takes most of it away.",
        (
            Evidence("turning", "turning", "torque, uncompensated"),
            Evidence("turning_printed", "turning", "with the printed -0.025 N·m·s/rad"),
        ),
        "Without ground friction, which holds the angle at zero in the other experiments.",
        ablations=(
            ablation(
                "turning",
                "turning",
                "K_oR = B_oR = 0",
                *both_copies(coupling_rotational_stiffness=0, coupling_rotational_damping=0),
            ),
            ablation("turning", "turning", "n = 0", "channels.lan.round_trip_delay=0", number=2),
            ablation(
                "turning_printed",
                "turning",
                "uncompensated",
                *both_copies(**{"compensation.theta": 0}),
            ),
        ),
    ),
    Statement(
        "users-notice",
        "8.2",
        "Users notice the improvement after compensation.",
        (
            Evidence("free_motion", "uncompensated", "net force without"),
            Evidence("free_motion_compensated", "compensated", "net force with"),
        ),
        "The force changes by half; differences in force of about a tenth are perceptible, so that "
        "users could notice it.",
        undecidable="Perception is not simulated, and no limit of ours could tell.",
    ),
)
