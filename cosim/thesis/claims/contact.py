"""Rigid contact, impulses and sliding: sections 7.2.2, 8.1 and 8.2."""

from __future__ import annotations

from cosim.thesis.claims.statement import Evidence, Statement, ablation, both_copies, server

CONTACT: tuple[Statement, ...] = (
    Statement(
        "softer-is-felt",
        "8.1",
        "Softer couplers degrade what the user feels, in rigid contact above all.",
        (
            Evidence("wall_push_centralized_remote", "soft_contact", "remote user against a wall"),
            Evidence("wall_push_centralized_stiffest", "stiffest", "nearly the stiffest"),
            Evidence("wall_push_centralized_local", "stiff_contact", "user at the server"),
        ),
        "How far a finger goes in is its force over its coupler's stiffness. What the network "
        "decides is which stiffness there can be: of a hand on a box that a wall holds, theory "
        "has 228 N/m as the limit at n = 1, over which 1.5 N yield by 6.8 mm.",
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
)
