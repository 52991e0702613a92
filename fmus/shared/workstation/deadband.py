"""The deadband: what a packet need not tell, and how many packets that saves."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.shared.workstation.fingers import ALL_FINGER_INPUTS
from fmus.shared.workstation.short_forms import integer, output, real
from fmus.table import ModelVariable


def deadband_parameters() -> tuple[ModelVariable, ...]:
    """What a packet need not tell because nobody would feel it."""
    return (
        integer(
            "network_ticks",
            "Control periods in a network period, for the deadband and the packet counters, as "
            "cohaptic sets it",
            8,
            minimum=1,
            maximum=1_000_000,
            meaning=Meaning.NETWORK_TICKS,
        ),
        real(
            "deadband",
            "Weber fraction by which the force that a receiver would feel may change before a "
            "packet has content again (0.1 is usual; Hinterseer et al. 2008); 0: every packet has",
            "1",
            0.0,
            minimum=0.0,
        ),
        real(
            "deadband_force",
            "Least force that the fraction is taken of: what a free hand feels (chosen)",
            "N",
            0.2,
            minimum=0.0,
        ),
        real(
            "deadband_arm",
            "Distance from the box's middle at which its torque is felt as a force (chosen)",
            "m",
            0.05,
            minimum=0.0,
        ),
        integer(
            "deadband_longest",
            "Network periods after which a packet has content even if nothing changed; packets "
            "between are keep-alives with the age of the content",
            16,
            minimum=1,
            maximum=1_000_000,
        ),
    )


def packet_counters(depends_on: tuple[str, ...] = ()) -> tuple[ModelVariable, ...]:
    """How much the deadband saves, 1 - sent / due; what is due and not sent is a keep-alive.

    ``depends_on`` adds to the fingers' inputs.
    """
    return (
        output("packets_due", "Packets so far, one each network period", None),
        output(
            "packets_sent",
            "Packets so far with content; the others are keep-alives",
            None,
            (*ALL_FINGER_INPUTS, *depends_on),
        ),
    )
