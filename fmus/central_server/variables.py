"""The variables of the central server."""

from __future__ import annotations

from fmus.shared.workstation import state as kept
from fmus.shared.workstation import variables as workstation
from fmus.shared.workstation.variables import PEERS
from fmus.shared.world import environment
from fmus.table import Group, Model

_CLIENTS = ("client_?.*", "peer_weight", "peer_valid", "peer_age")

_CLIENT = (
    *workstation.packet_inputs(motion=True, box=False, force=False),
    *workstation.wave_members(sent=False),
)
_TO_CLIENT = (
    *workstation.packet_outputs(motion=False, box=True, force=_CLIENTS),
    *workstation.wave_members(sent=True),
)

MODEL = Model(
    name="central_server",
    description="Server of the centralized architecture: simulates the only box, with own fingers "
    "at the control rate and its clients' held between packets, and sends their forces back",
    variables=(
        *workstation.station_parameters(),
        *workstation.wave_parameters(),
        *environment.coupler_parameters(
            environment.TABLE_8_1,
            environment.REMOTE_8_2,
            "Thesis, Table 8.1",
            "Thesis 8.2, what the remote user is given so that the loop is stable; Table 8.1 has "
            "the local values here",
        ),
        environment.compensation_group(),
        *environment.box_parameters(),
        *environment.peer_parameters(),
        environment.wall_group(),
        workstation.finger_group((), *environment.finger_contact_outputs()),
        *workstation.packet_counters(_CLIENTS),
        *workstation.peer_inputs(),
        Group("client", _CLIENT, count=PEERS, numbers="peer"),
        Group("to_client", _TO_CLIENT, count=PEERS),
        Group(
            "client_contact",
            workstation.peer_contact_outputs(_CLIENTS, "client"),
            count=PEERS,
            numbers="peer",
        ),
        *environment.environment_outputs(_CLIENTS),
    ),
    retunes=True,
    state=(
        *kept.station_state(),
        *kept.world_state(),
        *(
            member
            for peer, finger in kept.pairs(PEERS, 2)
            for member in (
                *kept.wave_state(f"wave[{peer}][{finger}].in", "force_channel"),
                *kept.vector(f"wave[{peer}][{finger}].position", "m", "force_channel"),
                *kept.vector(f"wave[{peer}][{finger}].velocity", "m/s", "force_channel"),
                *kept.vector(f"wave[{peer}][{finger}].integral", "N.s", "force_channel"),
            )
        ),
        *(member for peer in range(PEERS) for member in kept.packet_state(f"sent[{peer}]")),
    ),
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
        "wave.c",
        "five_bar.c",
    ),
    terminals=(
        *workstation.finger_terminals(),
        *(
            terminal
            for p in range(1, PEERS + 1)
            for terminal in (
                workstation.packet_terminal(f"client_{p}", f"What client {p} says", _CLIENT),
                workstation.packet_terminal(
                    f"to_client_{p}", f"What client {p} is told", _TO_CLIENT
                ),
            )
        ),
    ),
)
