"""Ports that a device could be on. Nothing is opened, because opening resets some boards."""

from __future__ import annotations

from pathlib import Path

_CAN_HARDWARE_TYPE = "280"
"""ARPHRD_CAN of Linux."""


def candidates() -> list[dict[str, str]]:
    """Serial ports and CAN interfaces, each with a URL to try and what the system says of it."""
    from serial.tools import list_ports  # pyright: ignore[reportMissingModuleSource]

    found = [
        {"url": f"haply://{port.device}", "description": str(port.description)}
        for port in list_ports.comports()
    ]
    network = Path("/sys/class/net")
    for interface in sorted(network.iterdir()) if network.is_dir() else []:
        kind = interface / "type"
        if kind.is_file() and kind.read_text("ascii").strip() == _CAN_HARDWARE_TYPE:
            found += [
                {"url": f"{driver}+socketcan://{interface.name}", "description": "CAN interface"}
                for driver in ("canopen", "odrive")
            ]
    return found
