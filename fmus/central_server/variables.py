"""The variables of the central server."""

from __future__ import annotations

from fmus.shared.workstation import state as kept
from fmus.shared.workstation.deadband import packet_counters
from fmus.shared.workstation.fingers import finger_group, finger_terminals
from fmus.shared.workstation.packets import packet_inputs, packet_outputs, packet_terminal
from fmus.shared.workstation.peers import PEERS, peer_contact_outputs, peer_inputs
from fmus.shared.workstation.station import station_parameters
from fmus.shared.workstation.waves import wave_members, wave_parameters
from fmus.shared.world import couplers, environment, intent
from fmus.table import Group, Model

_CLIENTS = ("client_?.*", "peer_weight", "peer_valid", "peer_age")

_CLIENT = (
    *packet_inputs(motion=True, box=False, force=False),
    *wave_members(sent=False),
)
_TO_CLIENT = (
    *packet_outputs(motion=False, box=True, force=_CLIENTS),
    *wave_members(sent=True),
)

MODEL = Model(
    name="central_server",
    description="Server of the centralized architecture: simulates the only box, with own fingers "
    "at the control rate and its clients' held between packets, and sends their forces back",
    variables=(
        *station_parameters(),
        *wave_parameters(),
        *couplers.coupler_parameters(
            couplers.TABLE_8_1,
            couplers.REMOTE_8_2,
            "Thesis, Table 8.1",
            "Thesis 8.2, what the remote user is given so that the loop is stable; Table 8.1 has "
            "the local values here",
        ),
        couplers.compensation_group(),
        *environment.box_parameters(),
        *environment.peer_parameters(),
        environment.wall_group(),
        finger_group((), *environment.finger_contact_outputs()),
        *packet_counters(_CLIENTS),
        *peer_inputs(),
        Group("client", _CLIENT, count=PEERS, numbers="peer"),
        Group("to_client", _TO_CLIENT, count=PEERS),
        Group(
            "client_contact",
            peer_contact_outputs(_CLIENTS, "client"),
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
        "wave.c",
        "five_bar.c",
    ),
    terminals=(
        *finger_terminals(),
        *(
            terminal
            for p in range(1, PEERS + 1)
            for terminal in (
                packet_terminal(f"client_{p}", f"What client {p} says", _CLIENT),
                packet_terminal(f"to_client_{p}", f"What client {p} is told", _TO_CLIENT),
            )
        ),
    ),
)
