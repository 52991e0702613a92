"""Which nodes are alive on a CAN bus, by listening alone: nothing is sent.

A heartbeat does not tell a node's profile, so a CANopen node is shown for every driver that could
speak to it.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

CANOPEN_HEARTBEAT, ODRIVE_HEARTBEAT = 0x700, 0x01
AXIS_STATES = 15
"""States that an ODrive's axis has."""
STATES = {0: "has just started", 4: "stopped", 5: "operational", 127: "pre-operational"}


def heard(identifier: int, data: bytes) -> tuple[str, int, str] | None:
    """Driver, node and state in a heartbeat of CANopen or ODrive; ``None`` for other frames."""
    if identifier & 0x780 == CANOPEN_HEARTBEAT and len(data) == 1 and identifier & 0x7F:
        state = STATES.get(data[0] & 0x7F)
        return None if state is None else ("canopen", identifier & 0x7F, state)
    if identifier & 0x1F == ODRIVE_HEARTBEAT and len(data) == 8 and data[4] < AXIS_STATES:
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
    return {
        (driver, node): state
        for (driver, node), state in found.items()
        if driver == "canopen" or not _is_of_canopen(node, found)
    }


def _is_of_canopen(axis: int, found: Mapping[tuple[str, int], str]) -> bool:
    """Whether what looks like an axis's heartbeat comes from a CANopen node that was heard, too."""
    return ("canopen", (axis << 5 | ODRIVE_HEARTBEAT) & 0x7F) in found


def scan(interface: str, seconds: float = 0.5) -> list[dict[str, str]]:
    """The nodes on an interface of the kernel's, with URLs to try.

    Raises:
        OSError: it cannot be listened to.
    """
    import can

    with can.Bus(interface="socketcan", channel=interface) as bus:
        found = nodes_on(bus, seconds)
    return suggestions(interface, found)


def suggestions(interface: str, found: Mapping[tuple[str, int], str]) -> list[dict[str, str]]:
    """What was heard, with a URL to try where a driver could use it.

    Drivers that want two nodes get the first two; an axis alone is shown at its interface.
    """
    shown: list[dict[str, str]] = []
    axes = sum(name == "odrive" for name, _ in found)
    for (driver, node), state in sorted(found.items()):
        if driver == "canopen":
            shown.append(_shown(interface, driver, [node], f"node {node} is {state}"))
            continue
        alone = "" if axes > 1 else "; it is alone, and the driver wants two, a joint each"
        said = f"ODrive axis {node} is {state}{alone}"
        shown.append({"url": interface, "description": said})
    for heard_as, driver in (("canopen", "cia402"), ("odrive", "odrive")):
        nodes = sorted(node for name, node in found if name == heard_as)[:2]
        if len(nodes) == 2:
            said = f"nodes {nodes[0]} and {nodes[1]}, a joint each"
            shown.append(_shown(interface, driver, nodes, said))
    return shown


def _shown(interface: str, driver: str, nodes: list[int], said: str) -> dict[str, str]:
    numbers = ",".join(map(str, nodes))
    return {"url": f"{driver}+socketcan://{interface}?nodes={numbers}", "description": said}
