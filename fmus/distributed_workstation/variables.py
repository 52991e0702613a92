"""The variables of the distributed workstation."""

from __future__ import annotations

from fmus.shared.workstation import state as kept
from fmus.shared.workstation.deadband import packet_counters
from fmus.shared.workstation.fingers import finger_group, finger_terminals
from fmus.shared.workstation.packets import packet_inputs, packet_outputs, packet_terminal
from fmus.shared.workstation.peers import PEERS, peer_contact_outputs, peer_inputs
from fmus.shared.workstation.station import station_parameters
from fmus.shared.world import couplers, environment, intent
from fmus.table import Group, Model

_PEERS = ("peer_?.*", "peer_weight", "peer_valid", "peer_age")

_SHARED = packet_outputs(motion=True, box=True)
_PEER = packet_inputs(motion=True, box=True, force=False)

MODEL = Model(
    name="distributed_workstation",
    description="Workstation of the distributed architecture: own fingers at the control rate, own "
    "copy of the box, remote fingers and copies held between packets",
    variables=(
        *station_parameters(),
        *couplers.coupler_parameters(
            couplers.TABLE_8_1,
            couplers.REMOTE_8_2,
            "Thesis, Table 8.1",
            couplers.OUR_SET,
        ),
        *couplers.coupling_parameters(),
        couplers.compensation_group(),
        *environment.box_parameters(),
        *environment.peer_parameters(),
        environment.wall_group(),
        finger_group((), *environment.finger_contact_outputs()),
        *packet_counters(),
        *peer_inputs(),
        Group("peer", _PEER, count=PEERS, numbers="peer"),
        Group("shared", _SHARED),
        Group(
            "peer_contact",
            peer_contact_outputs(_PEERS, "peer"),
            count=PEERS,
            numbers="peer",
        ),
        *environment.environment_outputs(_PEERS),
    ),
    work_bytes=6144,
    retunes=True,
    state=(
        *kept.station_state(),
        *kept.packet_state("sent"),
        *kept.world_state(),
        *intent.intent_state(),
    ),
    ideal={**kept.IDEAL_STATION, **kept.IDEAL_WORLD},
    sources=(
        "model.c",
        "world.c",
        "box.c",
        "lattice.c",
        "contact.c",
        "finger.c",
        "intent.c",
        "packet.c",
        "passivity.c",
        "port.c",
        "velocity_estimator.c",
        "five_bar.c",
    ),
    terminals=(
        *finger_terminals(),
        packet_terminal("shared", "What the peers are told", _SHARED),
        *(packet_terminal(f"peer_{p}", f"What peer {p} says", _PEER) for p in range(1, PEERS + 1)),
    ),
)
