"""What a workstation is told of its peers, and what their fingers do to its box."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.shared.workstation.choices import CONTACT_STATE
from fmus.shared.workstation.fingers import FINGERS
from fmus.shared.workstation.short_forms import output
from fmus.table import ModelVariable

PEERS = 3


def peer_inputs(peers: int = PEERS) -> tuple[ModelVariable, ...]:
    """What the link says of each of ``peers`` peers."""
    return (
        ModelVariable(
            name="peer_weight",
            description="Scales everything that comes from peer p, between 0 and 1",
            causality="input",
            unit="1",
            start=1.0,
            minimum=0.0,
            maximum=1.0,
            size=peers,
            meaning=Meaning.PEER_WEIGHT,
            each="peer",
        ),
        ModelVariable(
            name="peer_valid",
            description="False takes the weight of peer p as 0",
            causality="input",
            type="boolean",
            start=True,
            size=peers,
            meaning=Meaning.PEER_VALID,
            each="peer",
        ),
        ModelVariable(
            name="peer_age",
            description="Ticks since what peer p says was measured; 0 where the link does not say",
            causality="input",
            type="integer",
            start=0,
            minimum=0,
            size=peers,
            meaning=Meaning.PEER_AGE,
            each="peer",
        ),
    )


def peer_contact_outputs(depends_on: tuple[str, ...], who: str) -> tuple[ModelVariable, ...]:
    """The contacts of another workstation's fingers with the box that is simulated here."""
    members: list[ModelVariable] = []
    for number in range(1, FINGERS + 1):
        members += [
            output(
                f"finger_{number}_normal_force",
                f"Normal force of the {who}'s finger {number} on this box",
                "N",
                depends_on,
                meaning=Meaning.NORMAL_FORCE,
                finger=number,
            ),
            ModelVariable(
                name=f"finger_{number}_contact_state",
                description=f"State of the {who}'s finger {number} on this box",
                causality="output",
                type="enumeration",
                enumeration=CONTACT_STATE,
                meaning=Meaning.CONTACT_STATE,
                finger=number,
                depends_on=depends_on,
            ),
            output(
                f"finger_{number}_contact_losses",
                f"How often the contact of the {who}'s finger {number} has ended",
                None,
                depends_on,
            ),
            output(
                f"finger_{number}_energy",
                f"Energy that the {who}'s finger {number} has put into this box",
                "J",
                depends_on,
                meaning=Meaning.PORT_ENERGY,
                finger=number,
            ),
        ]
    members.append(
        output(
            "coupling_energy",
            f"Energy that the {who}'s copy of the box has put into this one",
            "J",
            depends_on,
        )
    )
    return tuple(members)
