"""What chapters 7 and 8 of the thesis say, and which expectations of which scenarios decide it.

A statement names labels of ``expect:`` entries in ``scenarios/thesis``, and ablations: the same
runs without what the statement says matters, in which the same expectations must not hold. It is
agreed with when all evidence holds and every ablation fails, disagreed with when evidence that was
measured does not hold, and cannot be decided otherwise: where an ablation passes, the limits would
have been met anyway.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

Verdict = Literal["agree", "disagree", "cannot be decided"]


@dataclass(frozen=True, slots=True)
class Evidence:
    """The expectations with one label in one scenario, and what they mean to the statement.

    Where their limits come from is in ``cosim.thesis.predictions``.
    """

    scenario: str
    label: str
    meaning: str


@dataclass(frozen=True, slots=True)
class Ablation:
    """A run of the evidence without what matters: the label's expectations must not all hold."""

    name: str
    evidence: Evidence
    sets: tuple[str, ...]


def ablation(scenario: str, label: str, meaning: str, *sets: str, number: int = 1) -> Ablation:
    """One that is called after its scenario."""
    name = f"{scenario}_without" + (f"_{number}" if number > 1 else "")
    return Ablation(name, Evidence(scenario, label, meaning), sets)


def both_copies(**values: float | str) -> tuple[str, ...]:
    """Overrides of both distributed workstations."""
    return tuple(
        f"components.vr_{which}.parameters.{name}={value}"
        for which in "ab"
        for name, value in values.items()
    )


def server(**values: float | str) -> tuple[str, ...]:
    """Overrides of the central server."""
    return tuple(f"components.server.parameters.{name}={value}" for name, value in values.items())


@dataclass(frozen=True, slots=True)
class Statement:
    """One claim in our words, with its section of the thesis and what decides it.

    Where the claim is not the thesis's, ``section`` is empty and the claim says whose it is.
    ``undecidable`` says why no simulation can decide it; empty where one can.
    """

    name: str
    section: str
    claim: str
    evidence: tuple[Evidence, ...]
    remark: str = ""
    ablations: tuple[Ablation, ...] = ()
    undecidable: str = ""


STATEMENTS: tuple[Statement, ...] = (
    Statement(
        "centralized-unstable",
        "8.1",
        "With the gains of table 8.1 the centralized controller is unstable, as figure 5.1 "
        "predicts.",
        (Evidence("grasp_centralized", "instability", "force ripple of the worst contact"),),
        "The single-axis theory has ρ = 1.20 at n = 1. With relaxed hands (100 N/m, 3 N·s/m) the "
        "remote fingers run into a limit cycle: its rms is the ripple.",
        ablations=(
            ablation(
                "grasp_centralized",
                "instability",
                "n = 0, where the theory has 0.965",
                "channels.lan.round_trip_delay=0",
            ),
        ),
    ),
    Statement(
        "distributed-grasps",
        "8.1",
        "Under the distributed controller the users can grasp and move the box together.",
        (
            Evidence("grasp_distributed", "grasp", "n = 1"),
            Evidence("grasp_distributed_n0", "grasp", "n = 0"),
            Evidence("grasp_distributed_n2", "grasp", "n = 2"),
            Evidence("grasp_distributed_apart", "together", "n = 1, users who want other things"),
        ),
        "Users who want the same carry the box whatever is between the stations; what the "
        "controller does shows in how near the copies stay. At rest the ground's friction can hold "
        "a copy 0.32 mm (along the faces) to 0.47 mm (along the normals) from the other's pull. "
        "With K_o = B_o = 0 that alone would do for them, not for users who want other things.",
        ablations=(
            ablation(
                "grasp_distributed_apart",
                "together",
                "nothing between the copies: K_12 = K_o = B_o = 0",
                *both_copies(
                    coupling_stiffness=0,
                    coupling_damping=0,
                    remote_normal_stiffness=0,
                    remote_tangential_stiffness=0,
                ),
            ),
            ablation(
                "grasp_distributed_apart",
                "together",
                "nothing between the boxes: K_o = B_o = 0",
                *both_copies(coupling_stiffness=0, coupling_damping=0),
                number=2,
            ),
            ablation(
                "grasp_distributed_apart",
                "together",
                "n = 16",
                "channels.lan.round_trip_delay=16",
                number=3,
            ),
            ablation(
                "grasp_distributed_apart",
                "together",
                "70 % loss",
                "channels.lan.loss=0.7",
                number=4,
            ),
            ablation("grasp_distributed", "grasp", "n = 16", "channels.lan.round_trip_delay=16"),
            ablation("grasp_distributed", "grasp", "70 % loss", "channels.lan.loss=0.7", number=2),
            *(
                ablation(
                    f"grasp_distributed{delay}",
                    "grasp",
                    "smooth fingers: friction 0",
                    *both_copies(static_friction=0, kinetic_friction=0),
                    number=3,
                )
                for delay in ("", "_n0", "_n2")
            ),
        ),
    ),
    Statement(
        "damped-hand",
        "8.1",
        "With the unstable centralized controller a user has to add significant damping to hold "
        "the box at all.",
        (
            Evidence("grasp_centralized", "instability", "relaxed hands: it oscillates"),
            Evidence("grasp_centralized_firm_hand", "damped_hand", "firm, damped hands: it holds"),
        ),
        ablations=(
            ablation(
                "grasp_centralized_firm_hand",
                "damped_hand",
                "relaxed hands",
                *(
                    f"components.operator_{finger}.parameters.impedance=relaxed"
                    for finger in ("a1", "a2", "b1", "b2")
                ),
            ),
        ),
    ),
    Statement(
        "softer-is-stable",
        "8.1",
        "Softer couplers for the user across the network avoid the instability.",
        (Evidence("grasp_centralized_soft", "softer", "170 N/m in place of 800 N/m"),),
        ablations=(
            ablation(
                "grasp_centralized_soft",
                "softer",
                "the local user's couplers for the remote one",
                *server(
                    remote_normal_stiffness=800,
                    remote_tangential_stiffness=1200,
                    remote_tangential_damping=10,
                ),
            ),
        ),
    ),
    Statement(
        "softer-is-felt",
        "8.1",
        "That degrades what the user feels, in rigid contact above all.",
        (
            Evidence("wall_push_centralized_remote", "soft_contact", "remote user against a wall"),
            Evidence("wall_push_centralized_stiffest", "stiffest", "nearly the stiffest"),
            Evidence("wall_push_centralized_local", "stiff_contact", "user at the server"),
        ),
        "How far a finger goes in is its force over its coupler's stiffness. What the network "
        "decides is which stiffness there can be: of a hand on a box that a wall holds, theory "
        "has 228 N/m as the limit at n = 1, over which 1.5 N yield by 6.8 mm. In simulation a "
        "little more holds, with friction in the joints: 6.3 mm at 240 N/m.",
        ablations=(
            ablation(
                "wall_push_centralized_local",
                "stiff_contact",
                "as soft as the remote user's coupler",
                *server(local_normal_stiffness=170),
            ),
            ablation(
                "wall_push_centralized_remote",
                "soft_contact",
                "as stiff as the local user's coupler",
                *server(remote_normal_stiffness=800),
            ),
            ablation(
                "wall_push_centralized_stiffest",
                "stiffest",
                "400 N/m, beyond the limit",
                *server(remote_normal_stiffness=400),
            ),
        ),
    ),
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
    Statement(
        "stiffer-contact",
        "8.2",
        "Pushing against a stiff wall, the distributed user and the local centralized user feel a "
        "much stiffer contact than the remote centralized user.",
        (
            Evidence("wall_push_distributed", "stiff_contact", "distributed"),
            Evidence("wall_push_centralized_local", "stiff_contact", "centralized, local"),
            Evidence("wall_push_centralized_remote", "soft_contact", "centralized, remote"),
        ),
        ablations=(
            ablation(
                "wall_push_distributed",
                "stiff_contact",
                "as soft as the remote user's coupler",
                *both_copies(local_normal_stiffness=170),
            ),
            ablation(
                "wall_push_centralized_local",
                "stiff_contact",
                "as soft as the remote user's coupler",
                *server(local_normal_stiffness=170),
            ),
            ablation(
                "wall_push_centralized_remote",
                "soft_contact",
                "as stiff as the local user's coupler",
                *server(remote_normal_stiffness=800),
            ),
        ),
    ),
    Statement(
        "moment-cancellation",
        "7.2.2",
        "Impulses that cancel the hand's momentum make a rigid contact feel more rigid.",
        (
            Evidence("rigid_contact", "no_impulses", "without impulses"),
            Evidence("rigid_contact_cancelled", "impulses", "with impulses"),
        ),
        ablations=(
            ablation(
                "rigid_contact_cancelled",
                "impulses",
                "without impulses",
                "components.vr_a.parameters.moment_cancellation=false",
            ),
            ablation(
                "rigid_contact",
                "no_impulses",
                "with impulses",
                "components.vr_a.parameters.moment_cancellation=true",
            ),
        ),
    ),
    Statement(
        "sliding",
        "7.2.2",
        "A finger sticks until the tangential force reaches the static coefficient times the "
        "normal force, and slides under the kinetic one times it.",
        (
            Evidence("sliding", "breaks_away", "the largest tangential force, 0.6 x 1 N"),
            Evidence("sliding", "slides", "while it slides, 0.3 x 1 N"),
        ),
        ablations=(
            ablation(
                "sliding",
                "breaks_away",
                "static friction as small as the kinetic",
                "components.vr_a.parameters.static_friction=0.3",
            ),
            ablation(
                "sliding",
                "slides",
                "kinetic friction as large as the static",
                "components.vr_a.parameters.kinetic_friction=0.6",
                number=2,
            ),
        ),
    ),
    Statement(
        "loss-negligible",
        "1.2, 8.1",
        "On a LAN such as that of table 1.1 loss and jitter are negligible for the grasp.",
        (
            Evidence("grasp_distributed_lan_2006", "grasp", "the LAN of table 1.1"),
            Evidence("grasp_distributed_lossy", "grasp", "20 % loss and jitter on top"),
        ),
        ablations=(
            ablation("grasp_distributed_lan_2006", "grasp", "70 % loss", "channels.lan.loss=0.7"),
            ablation("grasp_distributed_lossy", "grasp", "70 % loss", "channels.lan.loss=0.7"),
        ),
    ),
)


def experiments(statements: Sequence[Statement]) -> tuple[str, ...]:
    """Names of the scenarios in ``scenarios/thesis`` that the statements need, each once."""
    return tuple(
        dict.fromkeys(item.scenario for statement in statements for item in statement.evidence)
    )


def ablation_runs(
    statements: Sequence[Statement],
) -> dict[str, tuple[str, tuple[str, ...]]]:
    """The ablations' runs by name: file and overrides."""
    return {
        each.name: (f"thesis/{each.evidence.scenario}", each.sets)
        for statement in statements
        for each in statement.ablations
    }


EXPERIMENTS = experiments(STATEMENTS)
"""What chapter 8 needs."""


@dataclass(frozen=True, slots=True)
class Measured:
    """One piece of evidence with what was measured; ``found`` is empty where nothing was."""

    evidence: Evidence
    found: tuple[Mapping[str, Any], ...]
    failure: str = ""

    @property
    def passed(self) -> bool | None:
        """Whether every expectation held; ``None`` where nothing was measured."""
        if self.failure or not self.found:
            return None
        if any(entry["measured"] is None for entry in self.found):
            return None
        return all(entry["passed"] for entry in self.found)


@dataclass(frozen=True, slots=True)
class Decided:
    """A statement with its evidence, and with the ablations that had to fail."""

    statement: Statement
    measured: tuple[Measured, ...]
    ablated: tuple[Measured, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """Agree where all evidence holds and every ablation fails it."""
        if self.statement.undecidable:
            return "cannot be decided"
        passed = [item.passed for item in self.measured]
        if any(value is False for value in passed):
            return "disagree"
        could_fail = bool(self.ablated) and all(item.passed is False for item in self.ablated)
        return "agree" if passed and all(passed) and could_fail else "cannot be decided"


def decide(
    summaries: Mapping[str, Mapping[str, Any]],
    failures: Mapping[str, str],
    statements: Sequence[Statement] = STATEMENTS,
) -> Sequence[Decided]:
    """Hold statements against the summaries of the runs (by scenario name, or ablation's)."""

    def measured(evidence: Evidence, run: str) -> Measured:
        entries = summaries.get(run, {}).get("expectations", ())
        found = tuple(entry for entry in entries if entry["label"] == evidence.label)
        return Measured(evidence, found, failures.get(run, ""))

    return [
        Decided(
            statement,
            tuple(measured(evidence, evidence.scenario) for evidence in statement.evidence),
            tuple(measured(each.evidence, each.name) for each in statement.ablations),
        )
        for statement in statements
    ]
