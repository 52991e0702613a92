"""The variables of the remote client."""

from __future__ import annotations

from fmus.shared.workstation import state as kept
from fmus.shared.workstation.deadband import packet_counters
from fmus.shared.workstation.fingers import ALL_FINGER_INPUTS, finger_group, finger_terminals
from fmus.shared.workstation.packets import packet_inputs, packet_outputs, packet_terminal
from fmus.shared.workstation.peers import peer_inputs
from fmus.shared.workstation.short_forms import BOX_POSE, POSE, VELOCITY, planar, real
from fmus.shared.workstation.station import station_parameters
from fmus.shared.workstation.waves import wave_members, wave_parameters
from fmus.state import words
from fmus.table import Group, Model

_UP = (
    *packet_outputs(motion=True, box=False),
    *wave_members(sent=True, depends_on=ALL_FINGER_INPUTS),
)
_DOWN = (
    *packet_inputs(motion=False, box=True, force=True),
    *wave_members(sent=False),
)
_BOX = ("down.box_*",)

MODEL = Model(
    name="remote_client",
    description="Client of the centralized architecture: sends its fingers' motion to the server "
    "and renders the forces that come back, held between packets",
    variables=(
        *station_parameters(peers=False),
        *wave_parameters(),
        real(
            "local_damping",
            "Damping of the own fingers that replaces the received force as the weight of the "
            "server goes to 0 (chosen)",
            "N.s/m",
            3.0,
            minimum=0.0,
        ),
        real(
            "deadband_stiffness",
            "Of the coupler that the server has for this user, for the deadband (section 8.2)",
            "N/m",
            170.0,
            minimum=0.0,
        ),
        real("deadband_damping", "Of the same coupler", "N.s/m", 3.0, minimum=0.0),
        finger_group(
            (
                "down.finger_?_force",
                "down.finger_?_wave",
                "down.source_tick",
                "peer_weight",
                "peer_valid",
            )
        ),
        *packet_counters(),
        *peer_inputs(peers=1),
        Group("down", _DOWN, numbers="peer"),
        Group("up", _UP),
        planar("box_pose", "Pose of the server's box, for display", POSE, _BOX, meaning=BOX_POSE),
        planar("box_velocity", "Velocity of the server's box, for display", VELOCITY, _BOX),
    ),
    state=(
        *kept.station_state(),
        *kept.packet_state("sent"),
        *(
            member
            for finger in range(2)
            for member in (
                *kept.wave_state(f"wave[{finger}].back", "force_channel"),
                *kept.vector(f"wave[{finger}].integral", "N.s", "force_channel"),
                *kept.vector(f"wave[{finger}].origin", "m", "force_channel"),
                *words((f"wave[{finger}].started",)),
            )
        ),
    ),
    ideal=kept.IDEAL_STATION,
    sources=(
        "model.c",
        "finger.c",
        "packet.c",
        "passivity.c",
        "port.c",
        "velocity_estimator.c",
        "wave.c",
        "five_bar.c",
    ),
    terminals=(
        *finger_terminals(),
        packet_terminal("up", "What the server is told", _UP),
        packet_terminal("down", "What the server says", _DOWN),
    ),
)
