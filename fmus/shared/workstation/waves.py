"""Wave variables between a client and its server; the C side is ``wave.h``."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.shared.workstation.choices import FORCE_CHANNEL
from fmus.shared.workstation.fingers import FINGERS
from fmus.shared.workstation.short_forms import choice, output, real, signal
from fmus.table import ModelVariable


def wave_parameters() -> tuple[ModelVariable, ...]:
    """How a client and its server exchange motion and force; both must agree."""
    return (
        choice("force_channel", "What carries hand and force; as at the other end", FORCE_CHANNEL),
        real(
            "wave_impedance",
            "Impedance b of the wave channel, as at the other end: small feels light in free "
            "motion, large feels hard in contact (chosen)",
            "N.s/m",
            10.0,
            minimum=0.0,
        ),
    )


def wave_members(*, sent: bool, depends_on: tuple[str, ...] = ()) -> tuple[ModelVariable, ...]:
    """The waves of a packet, as outputs or as inputs."""
    members: list[ModelVariable] = []
    for number in range(1, FINGERS + 1):
        name, text = f"finger_{number}_wave", f"Integral of the wave of finger {number}"
        if sent:
            members.append(output(name, text, "N.s", depends_on, size=2))
        else:
            members.append(signal(name, text, "N.s", size=2, meaning=Meaning.PEER_STATE))
    return tuple(members)
