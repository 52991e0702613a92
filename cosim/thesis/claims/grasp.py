"""Grasp and carry, section 8.1: who can hold the box together, over which network."""

from __future__ import annotations

from cosim.thesis.claims.statement import Evidence, Statement, ablation, both_copies, server

GRASP: tuple[Statement, ...] = (
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
        "a copy 0.32 mm (along the faces) to 0.47 mm (along the normals) from the other's pull, on "
        "the way an odd sample of delay adds 0.39 mm. With K_o = B_o = 0 that alone would do for "
        "them, not for users who want other things.",
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
