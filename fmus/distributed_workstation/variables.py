"""The variables of the distributed workstation."""

from __future__ import annotations

from fmus.shared.workstation import state as kept
from fmus.shared.workstation import variables as workstation
from fmus.shared.workstation.variables import PEERS
from fmus.shared.world import environment
from fmus.table import Group, Model

_PEERS = ("peer_?.*", "peer_weight", "peer_valid", "peer_age")

_SHARED = workstation.packet_outputs(motion=True, box=True)
_PEER = workstation.packet_inputs(motion=True, box=True, force=False)

MODEL = Model(
    name="distributed_workstation",
    description="Workstation of the distributed architecture: own fingers at the control rate, own "
    "copy of the box, remote fingers and copies held between packets",
    variables=(
        *workstation.station_parameters(),
        *environment.coupler_parameters(
            environment.TABLE_8_1,
            environment.REMOTE_8_2,
            "Thesis, Table 8.1",
            environment.OUR_SET,
        ),
        *environment.coupling_parameters(),
        environment.compensation_group(),
        *environment.box_parameters(),
        *environment.peer_parameters(),
        environment.wall_group(),
        workstation.finger_group((), *environment.finger_contact_outputs()),
        *workstation.packet_counters(),
        *workstation.peer_inputs(),
        Group("peer", _PEER, count=PEERS, numbers="peer"),
        Group("shared", _SHARED),
        Group(
            "peer_contact",
            workstation.peer_contact_outputs(_PEERS, "peer"),
            count=PEERS,
            numbers="peer",
        ),
        *environment.environment_outputs(_PEERS),
    ),
    work_bytes=6144,
    retunes=True,
    state=(*kept.station_state(), *kept.packet_state("sent"), *kept.world_state()),
    ideal={**kept.IDEAL_STATION, **kept.IDEAL_WORLD},
    sources=(
        "model.c",
        "world.c",
        "box.c",
        "lattice.c",
        "contact.c",
        "finger.c",
        "packet.c",
        "passivity.c",
        "port.c",
        "velocity_estimator.c",
        "five_bar.c",
    ),
    terminals=(
        *workstation.finger_terminals(),
        workstation.packet_terminal("shared", "What the peers are told", _SHARED),
        *(
            workstation.packet_terminal(f"peer_{p}", f"What peer {p} says", _PEER)
            for p in range(1, PEERS + 1)
        ),
    ),
)
