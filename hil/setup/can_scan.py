"""Which nodes are alive on a CAN bus, by listening alone: nothing is sent."""

from __future__ import annotations

import time
from typing import Any

CANOPEN_HEARTBEAT, ODRIVE_HEARTBEAT = 0x700, 0x01
STATES = {0: "has just started", 4: "stopped", 5: "operational", 127: "pre-operational"}


def heard(identifier: int, data: bytes) -> tuple[str, int, str] | None:
    """Driver, node and state in a heartbeat of CANopen or ODrive; ``None`` for other frames."""
    if identifier & 0x780 == CANOPEN_HEARTBEAT and len(data) == 1 and identifier & 0x7F:
        return "canopen", identifier & 0x7F, STATES.get(data[0] & 0x7F, "in an unknown state")
    if identifier & 0x1F == ODRIVE_HEARTBEAT and len(data) == 8:
        state = {1: "idle", 8: "in closed loop"}.get(data[4], f"in state {data[4]}")
        error = int.from_bytes(data[:4], "little")
        return "odrive", identifier >> 5, state + (f", error 0x{error:x}" if error else "")
    return None


def nodes_on(bus: Any, seconds: float = 0.5) -> dict[tuple[str, int], str]:
    """Every (driver, node) whose heartbeat comes within some time on a python-can bus."""
    found: dict[tuple[str, int], str] = {}
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        frame = bus.recv(left)
        if frame is None or frame.is_extended_id or frame.is_remote_frame:
            continue
        told = heard(frame.arbitration_id, bytes(frame.data))
        if told is not None:
            found[told[:2]] = told[2]
    return found


def scan(interface: str, seconds: float = 0.5) -> list[dict[str, str]]:
    """The nodes on an interface of the kernel's, each with a URL to try.

    Raises:
        OSError: it cannot be listened to.
    """
    import can

    with can.Bus(interface="socketcan", channel=interface) as bus:
        found = nodes_on(bus, seconds)
    return [
        {
            "url": f"{driver}+socketcan://{interface}?nodes={node}",
            "description": f"node {node} is {state}",
        }
        for (driver, node), state in sorted(found.items())
    ]
