"""What lies past the thesis and scenarios of its own decide, as statements like chapter 8's."""

from __future__ import annotations

from cosim.thesis.statements import Evidence, Statement, experiments

_FUTURE = "9"

EXTENSIONS: tuple[Statement, ...] = (
    Statement(
        "three-and-four-users",
        _FUTURE,
        "Three and four users carry one box under the distributed controller, with the couplers of "
        "two.",
        (
            Evidence("three_users", "three_users", "three users, one finger each"),
            Evidence("four_users", "four_users", "four users, a finger on each side"),
        ),
        "Every copy hears every other station. Each further user adds couplers that hold the "
        "copies together, so that the theory's radius falls with their number (the figure below).",
    ),
    Statement(
        "deformable",
        _FUTURE,
        "The same grasp carries a soft object: 3 x 3 masses with springs in place of the box.",
        (Evidence("grasp_deformable", "deformable", "mass-spring square, n = 1"),),
        "The copies are pulled together as wholes; their dents follow from each copy's fingers.",
    ),
    Statement(
        "time-domain-passivity",
        "",
        "A passivity observer and controller on the rendered forces calms the unstable centralized "
        "grasp (Hannaford and Ryu, 2002).",
        (
            Evidence("grasp_centralized", "instability", "without"),
            Evidence("grasp_centralized_passive", "passive", "with, reserve 1 mJ"),
        ),
        "It does not make the loop stable: it damps what has become active. With an unlimited "
        "reserve the energy that the users have put in pays for the oscillation, and the ripple "
        "stays above 0.5 N.",
    ),
    Statement(
        "wave-variables",
        "",
        "Wave variables on the centralized force channel make the same gains stable (Niemeyer and "
        "Slotine, 1991).",
        (
            Evidence("grasp_centralized", "instability", "positions and forces"),
            Evidence("grasp_centralized_wave", "wave", "wave variables, same couplers"),
        ),
        "The price is paid in softness: in steady contact the server's image lags the hand by "
        "force times delay over the wave impedance.",
    ),
    Statement(
        "deadband",
        "",
        "A Weber deadband of a tenth saves packets, and the grasp is as steady (Hinterseer et al., "
        "2008).",
        (Evidence("grasp_deadband", "deadband", "k = 0.1, content of 1280 packets renewed"),),
    ),
)

EXTENSION_EXPERIMENTS = experiments(EXTENSIONS)
"""The scenarios that these need."""
