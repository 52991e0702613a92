"""What lies past the thesis and scenarios of its own decide, as statements like chapter 8's."""

from __future__ import annotations

from cosim.thesis.claims.statement import Evidence, Statement, ablation, both_copies, server

_FUTURE = "9"


def _passivity(name: str, value: float) -> tuple[str, ...]:
    return tuple(
        f"components.{station}.parameters.passivity_{name}={value}"
        for station in ("server", "client")
    )


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
        ablations=tuple(
            ablation(
                scenario,
                scenario,
                "nothing between the copies: K_12 = K_o = B_o = 0",
                *(
                    f"components.vr_{station}.parameters.{name}=0"
                    for station in stations
                    for name in (
                        "coupling_stiffness",
                        "coupling_damping",
                        "remote_normal_stiffness",
                        "remote_tangential_stiffness",
                    )
                ),
            )
            for scenario, stations in (("three_users", "abc"), ("four_users", "abcd"))
        ),
    ),
    Statement(
        "deformable",
        _FUTURE,
        "The same grasp carries a soft object: 3 x 3 masses with springs in place of the box.",
        (Evidence("grasp_deformable", "deformable", "mass-spring square, n = 1"),),
        "The copies are pulled together as wholes; their dents follow from each copy's fingers.",
        ablations=(
            ablation(
                "grasp_deformable",
                "deformable",
                "smooth fingers: friction 0",
                *both_copies(static_friction=0, kinetic_friction=0),
            ),
        ),
    ),
    Statement(
        "time-domain-passivity",
        "",
        "A passivity observer and controller on the rendered forces calms the unstable centralized "
        "grasp (Hannaford and Ryu, 2002).",
        (
            Evidence("grasp_centralized", "instability", "without"),
            Evidence("grasp_centralized_passive", "passive", "damping of at most 10 N·s/m"),
            *(
                Evidence(
                    "grasp_centralized_passive",
                    "passive",
                    f"damping of at most {damping} N·s/m",
                    f"grasp_centralized_passive_with_{damping}",
                    _passivity("damping_limit", damping),
                )
                for damping in (5, 20)
            ),
        ),
        "With a reserve of 1 mJ. It does not make the loop stable: it damps what has become "
        "active. Damping that overshoots (above 0.34 m_h/T_c = 35 N·s/m) is no help, and with an "
        "unlimited reserve the energy that the users have put in pays for the oscillation.",
        ablations=(
            ablation(
                "grasp_centralized_passive",
                "passive",
                "without the controller",
                "components.client.parameters.passivity=none",
                *server(passivity="none"),
            ),
            ablation(
                "grasp_centralized_passive",
                "passive",
                "damping that overshoots, 50 N·s/m",
                *_passivity("damping_limit", 50),
                number=2,
            ),
            ablation(
                "grasp_centralized_passive",
                "passive",
                "no bound on the reserve",
                *_passivity("reserve", 1000),
                number=3,
            ),
            ablation(
                "grasp_centralized_passive",
                "passive",
                "too little damping, 1 N·s/m",
                *_passivity("damping_limit", 1),
                number=4,
            ),
        ),
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
        ablations=(
            ablation(
                "grasp_centralized_wave",
                "wave",
                "positions and forces",
                "components.client.parameters.force_channel=plain",
                *server(force_channel="plain"),
            ),
        ),
    ),
    Statement(
        "alternating-delays",
        "5.1",
        "Delays that are stable each are unstable when they alternate: fixed delays prove nothing "
        "of a network whose delay varies (table 6.1, centralized).",
        (Evidence("alternating_delays", "alternating", "a sample up and down in turns, growth"),),
        "Every fixed delay of at most one sample each way has ρ below 0.9963; the alternation has "
        "1.000628 a period, 0.0803 a second, and no switching grows faster than 1.0008 "
        "('cohaptic theory robust switching').",
        ablations=(
            ablation(
                "alternating_delays",
                "alternating",
                "the sample always down",
                "channels.lan.trace={forward: [0], backward: [1]}",
                number=1,
            ),
            ablation(
                "alternating_delays",
                "alternating",
                "the sample always up",
                "channels.lan.trace={forward: [1], backward: [0]}",
                number=2,
            ),
        ),
    ),
    Statement(
        "deadband",
        "",
        "A Weber deadband of a tenth of the force that is felt saves the content of four packets "
        "in five, and the grasp is as steady (Hinterseer et al., 2008).",
        (
            Evidence("grasp_deadband", "deadband", "k = 0.1, of 1280 packets at most 256"),
            Evidence(
                "grasp_deadband",
                "deadband",
                "with linear prediction",
                "grasp_deadband_with_linear",
                both_copies(predictor="linear"),
            ),
        ),
        "A keep-alive, a head with the content's age, goes in place of the content. Published at "
        "1 kHz: 85 % (Hirche), 90 % (Hinterseer 2008), 96 % (Kammerl 2010) saved; at 128 Hz "
        "there is an eighth as much to save.",
        ablations=(
            ablation(
                "grasp_deadband",
                "deadband",
                "without a deadband",
                *both_copies(deadband=0),
                number=1,
            ),
            ablation(
                "grasp_deadband",
                "deadband",
                "a millionth in place of a tenth",
                *both_copies(deadband=1e-6),
                number=2,
            ),
            ablation(
                "grasp_deadband",
                "deadband",
                "a hundred in place of a tenth: nothing is renewed",
                *both_copies(deadband=100, deadband_longest=100000),
                number=3,
            ),
            ablation(
                "grasp_deadband",
                "deadband",
                "one in place of a tenth, and no renewal after a while",
                *both_copies(deadband=1, deadband_longest=100000),
                number=4,
            ),
        ),
    ),
)
