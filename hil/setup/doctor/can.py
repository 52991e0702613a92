"""CAN interfaces: whether they are up, on the bus, and keep no stale torques."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from hil.setup.doctor.machine import read
from hil.setup.doctor.note import DoctorNote, bad, good, poor

CAN_HARDWARE_TYPE = "280"
"""ARPHRD_CAN of Linux."""
LONGEST_QUEUE = 16
"""Frames that may wait in an interface: four ticks of four."""


def can_notes(
    root: Path = Path("/"), details: Mapping[str, Any] | None = None
) -> Iterator[DoctorNote]:
    """Every CAN interface; ``details`` is what ``ip -json -details link`` says of each by name."""
    network = root / "sys/class/net"
    names = [
        place.name
        for place in (sorted(network.iterdir()) if network.is_dir() else [])
        if read(place / "type") == CAN_HARDWARE_TYPE
    ]
    if not names:
        yield good("can", "there is no CAN interface")
        return
    known = _details() if details is None else details
    for name in names:
        yield _up(network / name, name)
        yield _queue(network / name, name)
        yield from _state(name, known.get(name, {}))


def _up(place: Path, name: str) -> DoctorNote:
    if read(place / "operstate") in {"up", "unknown"} and _flags(place) & 1:
        return good("can", f"{name} is up")
    return bad(
        "can",
        f"{name} is down: 'sudo ip link set {name} up type can bitrate 1000000 restart-ms 0'",
    )


def _queue(place: Path, name: str) -> DoctorNote:
    length = int(read(place / "tx_queue_len") or 0)
    if length <= LONGEST_QUEUE:
        return good("txqueuelen", f"{name} keeps {length} frames at most")
    return poor(
        "txqueuelen",
        f"{name} keeps {length} frames: torques wait there for a node that gets power later; "
        f"'sudo ip link set {name} txqueuelen 10'",
    )


def _state(name: str, details: Mapping[str, Any]) -> Iterator[DoctorNote]:
    data = details.get("linkinfo", {}).get("info_data", {})
    state = str(data.get("state", ""))
    if state in {"BUS-OFF", "ERROR-PASSIVE", "ERROR-WARNING"}:
        yield bad(
            "can state",
            f"{name} is {state}: nobody acknowledges its frames; look at bit rate, terminators "
            "(60 ohms between the wires) and the nodes' supply",
        )
    elif state:
        yield good("can state", f"{name} is {state}")
    if data.get("restart_ms", 0):
        yield poor(
            "can restart",
            f"{name} comes back by itself after bus-off ({data['restart_ms']} ms), with what is "
            f"in its queue: 'sudo ip link set {name} type can restart-ms 0'",
        )


def _flags(place: Path) -> int:
    return int(read(place / "flags") or "0", 16)


def _details() -> dict[str, Any]:
    with suppress(OSError, ValueError, subprocess.SubprocessError):
        said = subprocess.run(
            ["ip", "-json", "-details", "link"],
            capture_output=True,
            check=True,
            timeout=5,
        )
        links: list[dict[str, Any]] = json.loads(said.stdout)
        return {link["ifname"]: link for link in links if "ifname" in link}
    return {}
