"""What chapter 8 of the thesis says, and which expectations of which scenarios decide it.

A statement names labels of ``expect:`` entries in ``scenarios/thesis``. It is agreed with when all
of them hold, disagreed with when one that was measured does not, and undecided otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

Verdict = Literal["agree", "disagree", "cannot be decided"]


@dataclass(frozen=True, slots=True)
class Evidence:
    """The expectations with one label in one scenario, and what they mean to the statement."""

    scenario: str
    label: str
    meaning: str


@dataclass(frozen=True, slots=True)
class Statement:
    """One claim of the thesis in our words, with its section and what decides it."""

    name: str
    section: str
    claim: str
    evidence: tuple[Evidence, ...]
    remark: str = ""


STATEMENTS: tuple[Statement, ...] = (
    Statement(
        "centralized-unstable",
        "8.1",
        "With the gains of table 8.1 the centralized controller is unstable, as figure 5.1 "
        "predicts.",
        (Evidence("grasp_centralized", "instability", "force ripple of the worst contact"),),
        "The single-axis theory has ρ = 1.20 at n = 1. With relaxed hands (100 N/m, 3 N·s/m) the "
        "remote fingers run into a limit cycle: its rms is the ripple.",
    ),
    Statement(
        "distributed-grasps",
        "8.1",
        "Under the distributed controller the users can grasp and move the box together.",
        (
            Evidence("grasp_distributed", "grasp", "n = 1"),
            Evidence("grasp_distributed_n0", "grasp", "n = 0"),
            Evidence("grasp_distributed_n2", "grasp", "n = 2"),
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
    ),
    Statement(
        "softer-is-stable",
        "8.1",
        "Softer couplers for the user across the network avoid the instability.",
        (Evidence("grasp_centralized_soft", "softer", "170 N/m in place of 800 N/m"),),
    ),
    Statement(
        "softer-is-felt",
        "8.1",
        "That degrades what the user feels, in rigid contact above all.",
        (
            Evidence("wall_push_centralized_remote", "soft_contact", "remote user against a wall"),
            Evidence("wall_push_centralized_local", "stiff_contact", "user at the server"),
        ),
    ),
    Statement(
        "ideal-force",
        "8.2",
        "Ideally the forces on the object add up to the inertial force of its motion; the local "
        "user of the centralized controller comes to it.",
        (Evidence("free_motion_local", "local", "net force, inertial force 0.080 N"),),
    ),
    Statement(
        "uncompensated-force",
        "8.2",
        "Uncompensated, the distributed user has to apply a noticeably larger force for the same "
        "motion, by the damping that the network adds.",
        (Evidence("free_motion", "uncompensated", "net force, predicted 0.347 N at n = 1"),),
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
    ),
    Statement(
        "users-notice",
        "8.2",
        "Users notice the improvement after compensation.",
        (
            Evidence("free_motion", "uncompensated", "net force without"),
            Evidence("free_motion_compensated", "compensated", "net force with"),
        ),
        "Perception is not simulated. The force changes by half; differences in force of about a "
        "tenth are perceptible, so the change is one that users can notice.",
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
    ),
    Statement(
        "moment-cancellation",
        "7.2.2",
        "Impulses that cancel the hand's momentum make a rigid contact feel more rigid.",
        (
            Evidence("rigid_contact", "no_impulses", "without impulses"),
            Evidence("rigid_contact_cancelled", "impulses", "with impulses"),
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
    ),
)


def experiments(statements: Sequence[Statement]) -> tuple[str, ...]:
    """Names of the scenarios in ``scenarios/thesis`` that the statements need, each once."""
    return tuple(
        dict.fromkeys(item.scenario for statement in statements for item in statement.evidence)
    )


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
    """A statement with its evidence."""

    statement: Statement
    measured: tuple[Measured, ...]

    @property
    def verdict(self) -> Verdict:
        """Agree where all evidence holds, disagree where some does not, else undecided."""
        passed = [item.passed for item in self.measured]
        if any(value is False for value in passed):
            return "disagree"
        return "agree" if passed and all(passed) else "cannot be decided"


def decide(
    summaries: Mapping[str, Mapping[str, Any]],
    failures: Mapping[str, str],
    statements: Sequence[Statement] = STATEMENTS,
) -> Sequence[Decided]:
    """Hold statements against the summaries of the runs (by scenario name)."""
    return [
        Decided(
            statement,
            tuple(
                Measured(
                    evidence,
                    tuple(
                        entry
                        for entry in summaries.get(evidence.scenario, {}).get("expectations", ())
                        if entry["label"] == evidence.label
                    ),
                    failures.get(evidence.scenario, ""),
                )
                for evidence in statement.evidence
            ),
        )
        for statement in statements
    ]
