"""How a workstation samples, estimates and stays passive; the C side is ``workstation.h``."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.shared.workstation.choices import PASSIVITY, VELOCITY_ESTIMATOR
from fmus.shared.workstation.deadband import deadband_parameters
from fmus.shared.workstation.fingers import FINGERS
from fmus.shared.workstation.peers import PEERS
from fmus.shared.workstation.short_forms import choice, integer, real
from fmus.table import ModelVariable


def station_parameters(*, peers: bool = True) -> tuple[ModelVariable, ...]:
    """How a workstation samples and estimates; ``peers`` adds how many others there are."""
    count = integer("peers", "Number of other workstations in use", 1, minimum=0, maximum=PEERS)
    return (
        integer("fingers", "Number of own fingers in use", 2, minimum=1, maximum=FINGERS),
        *((count,) if peers else ()),
        real(
            "sample_period",
            "Control period T_c: the period at which the model is stepped, as cohaptic sets it",
            "s",
            1 / 1024,
            minimum=0.0,
            meaning=Meaning.SAMPLE_PERIOD,
        ),
        choice(
            "velocity_estimator",
            "How the tip's velocity is estimated",
            VELOCITY_ESTIMATOR,
        ),
        integer(
            "velocity_window",
            "Longest window of the velocity estimator in samples; a finite difference uses all of "
            "it. Samples older than this are forgotten, so that the estimate restarts after a gap",
            16,
            minimum=1,
            maximum=31,
        ),
        *deadband_parameters(),
        choice("passivity", "Passivity layer on the rendered force of every own finger", PASSIVITY),
        real(
            "passivity_damping_limit",
            "Largest damping of the passivity controller: below 0.34 m/T it does not overshoot, "
            "above 2 m/T it is unstable (chosen: 75 g at 1024 Hz)",
            "N.s/m",
            20.0,
            minimum=0.0,
        ),
        real(
            "passivity_reserve",
            "Most of the user's energy that is kept to be given back; a small reserve makes the "
            "controller act sooner. 0: no limit",
            "J",
            0.0,
            minimum=0.0,
        ),
    )
