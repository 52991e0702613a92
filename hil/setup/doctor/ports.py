"""Serial ports: who may open them, how late they are, and who else writes to them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from hil.setup.doctor.machine import read
from hil.setup.doctor.note import DoctorNote, bad, good, poor

LONGEST_LATENCY = 1
"""Milliseconds that an adapter may wait for more bytes."""


def port_notes(root: Path = Path("/")) -> Iterator[DoctorNote]:
    """Every serial port on USB, and ModemManager."""
    ports = sorted(
        place for pattern in ("ttyACM*", "ttyUSB*") for place in (root / "dev").glob(pattern)
    )
    if not ports:
        yield good("ports", "there is no serial port on USB")
    for port in ports:
        yield _permission(port)
        yield from _latency(root, port)
    if ports:
        yield _modem_manager(root)


def _permission(port: Path) -> DoctorNote:
    if os.access(port, os.R_OK | os.W_OK):
        return good("permission", f"{port} may be opened")
    return bad(
        "permission",
        f"{port} may not be opened: join its group ('sudo usermod -aG dialout $USER') and log in "
        "again",
    )


def _latency(root: Path, port: Path) -> Iterator[DoctorNote]:
    place = root / "sys/bus/usb-serial/devices" / port.name / "latency_timer"
    timer = read(place)
    if timer is None or not timer.isdecimal():
        return
    if int(timer) <= LONGEST_LATENCY:
        yield good("latency", f"{port.name} hands over what came within {timer} ms")
        return
    yield poor(
        "latency",
        f"{port.name} waits {timer} ms for more bytes before it hands over what came: drivers ask "
        f"for 1 ms when they open it; where that is refused, 'echo 1 | sudo tee {place}'",
    )


def _modem_manager(root: Path) -> DoctorNote:
    names = (read(place) for place in (root / "proc").glob("[0-9]*/comm"))
    if "ModemManager" not in names:
        return good("modem manager", "no ModemManager is there to write to new ports")
    rules = (root / "etc/udev/rules.d").glob("*.rules")
    if any("ID_MM_DEVICE_IGNORE" in (read(rule) or "") for rule in rules):
        return good("modem manager", "ModemManager runs, and is told to leave some ports alone")
    return bad(
        "modem manager",
        "ModemManager runs and writes 'AT' to every new port, which a board takes for commands: "
        'tell it not to with a udev rule, ENV{ID_MM_DEVICE_IGNORE}="1", for your board',
    )
