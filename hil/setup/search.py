"""Ports that a device could be on. No serial port is opened, because that resets some boards."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from cosim.base.errors import InputError
from hil.setup.driver_facts import DriverFacts
from hil.setup.registry import find, names

_CAN_HARDWARE_TYPE = "280"
"""ARPHRD_CAN of Linux."""
BY_ID = Path("/dev/serial/by-id")
"""Names that stay the same whatever else is plugged in, and in whatever order."""


def candidates(by_id: Path = BY_ID) -> list[dict[str, str]]:
    """Serial ports and CAN interfaces, each with a URL to try and what the system says of it.

    A board whose USB number a driver declares is shown for that driver alone.
    """
    from serial.tools import list_ports  # pyright: ignore[reportMissingModuleSource]

    kinds = _drivers()
    found: list[dict[str, str]] = []
    for port in list_ports.comports():
        number = (port.vid, port.pid)
        serial = [kind for kind in kinds if kind.found_on == "serial"]
        known = [kind for kind in serial if number in kind.usb_ids]
        usb = "" if port.vid is None else f" ({port.vid:04x}:{port.pid:04x})"
        found += [
            {
                "url": f"{kind.driver}://{lasting_name(port.device, by_id)}",
                "description": f"{port.description}{usb}",
            }
            for kind in known or serial
        ]
    for interface in can_interfaces():
        found += [
            {"url": f"{kind.driver}+socketcan://{interface}", "description": "CAN interface"}
            for kind in kinds
            if kind.found_on == "can"
        ]
    return found


def can_interfaces(network: Path = Path("/sys/class/net")) -> list[str]:
    """Names of the system's CAN interfaces."""
    return [
        place.name
        for place in (sorted(network.iterdir()) if network.is_dir() else [])
        if (place / "type").is_file()
        and (place / "type").read_text("ascii").strip() == _CAN_HARDWARE_TYPE
    ]


def nodes() -> list[dict[str, str]]:
    """Nodes whose heartbeats are heard on the CAN interfaces; nothing is sent."""
    from hil.setup.can_scan import scan

    found: list[dict[str, str]] = []
    for interface in can_interfaces():
        try:
            found += scan(interface)
        except OSError as error:
            found.append({"url": interface, "description": f"cannot be listened to: {error}"})
    return found


def lasting_name(port: str, by_id: Path = BY_ID) -> str:
    """The name of a port by what it is, where the system has one; else the port itself."""
    if by_id.is_dir():
        for link in sorted(by_id.iterdir()):
            if link.resolve() == Path(port).resolve():
                return str(link)
    return port


def _drivers() -> list[type[DriverFacts]]:
    """The installed drivers; one whose package is broken is told of by ``device list``."""
    kinds: list[type[DriverFacts]] = []
    for name in names():
        with suppress(InputError):
            kinds.append(find(name))
    return kinds
