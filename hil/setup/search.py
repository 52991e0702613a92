"""Ports that a device could be on. Nothing is opened, because opening resets some boards."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from cosim.base.errors import InputError
from hil.setup.driver_facts import DriverFacts
from hil.setup.registry import find, names

_CAN_HARDWARE_TYPE = "280"
"""ARPHRD_CAN of Linux."""


def candidates() -> list[dict[str, str]]:
    """Serial ports and CAN interfaces, each with a URL to try and what the system says of it."""
    from serial.tools import list_ports  # pyright: ignore[reportMissingModuleSource]

    kinds = _drivers()
    found: list[dict[str, str]] = []
    for port in list_ports.comports():
        number = (port.vid, port.pid)
        serial = [kind for kind in kinds if kind.found_on == "serial"]
        known = [kind for kind in serial if number in kind.usb_ids]
        found += [
            {"url": f"{kind.driver}://{port.device}", "description": str(port.description)}
            for kind in known or serial
        ]
    network = Path("/sys/class/net")
    for interface in sorted(network.iterdir()) if network.is_dir() else []:
        kind = interface / "type"
        if kind.is_file() and kind.read_text("ascii").strip() == _CAN_HARDWARE_TYPE:
            found += [
                {
                    "url": f"{kind.driver}+socketcan://{interface.name}",
                    "description": "CAN interface",
                }
                for kind in kinds
                if kind.found_on == "can"
            ]
    return found


def _drivers() -> list[type[DriverFacts]]:
    """The installed drivers; one whose package is broken is told of by ``device list``."""
    kinds: list[type[DriverFacts]] = []
    for name in names():
        with suppress(InputError):
            kinds.append(find(name))
    return kinds
