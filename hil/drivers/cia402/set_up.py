"""Setting up CiA 402 drives before the loop: mode, rated torque, and what takes the torque off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hil.device.errors import DeviceError
from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.protocol import Index, Object
from hil.drivers.canopen.remote import (
    CanopenTiming,
    Remote,
    map_pdo,
    network,
    refuse_errors,
    serial_of,
    silence_spare_pdos,
    try_watchdog,
)
from hil.drivers.cia402 import protocol as cia
from hil.wire.can_bus import CanBus

OUT = [Object(cia.CONTROL, 0, 2), Object(cia.TARGET, 0, 2)]
BACK = [Object(cia.STATUS, 0, 2), Object(cia.POSITION, 0, 4), Object(cia.DEMAND, 0, 2)]
MODE_TRIES = 50
"""Readings within which a drive has to show the mode that it was given."""


def rpdo_timer(value: int = 0) -> tuple[Object, int]:
    """The entry with the time (ms) in which a command has to come, and a value for it."""
    return Object(Index.RPDO, 5, 2), value


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundDrives:
    """What the drives said of themselves."""

    rated: tuple[float, float]
    """Rated torque of each (N.m)."""
    serial: str | None


def set_up_drives(
    bus: CanBus,
    nodes: Sequence[int],
    timing: CanopenTiming,
    counts_per_turn: tuple[int, int],
    *,
    mode: int | None,
    timed: bool,
) -> FoundDrives:
    """Set up the drives and start them; their torque is off.

    ``timed``: they are to time our commands. ``mode`` is ``None`` for the better one offered.

    Raises:
        DeviceError: a drive does not answer, refuses, does not keep what was written, reports an
            error, counts otherwise than the device file says, or would not take its torque off.
    """
    with network(bus) as package:
        drives = {n: Remote(package, n, timing.timeout, bus.name) for n in nodes}
        rated: list[float] = []
        for (number, drive), counts in zip(drives.items(), counts_per_turn, strict=True):
            drive.reset_node()
            refuse_errors(drive)
            silence_spare_pdos(drive)
            drive.write(Object(Index.HEARTBEAT_PRODUCER, 0, 2), timing.heartbeat_ms)
            _take_torque_off(drive)
            _choose_mode(drive, mode)
            _compare_counts(drive, counts)
            rated.append(_rated(drive))
            drive.write(Object(cia.TARGET, 0, 2), 0)
            map_pdo(drive, Index.TPDO, wire.positions_id(number), wire.EVERY_SYNC, BACK)
            map_pdo(drive, Index.RPDO, wire.outputs_id(number), wire.AT_ONCE, OUT)
            try_watchdog(drive, timing)
            if timed:
                _try_timer(drive, timing.watchdog_ms)
        serial = next(filter(None, map(serial_of, drives.values())), None)
        for drive in drives.values():
            drive.start()
    return FoundDrives(rated=(rated[0], rated[1]), serial=serial)


def _take_torque_off(drive: Remote) -> None:
    """Whatever ends the torque has to end it at once: a ramp brakes the hand."""
    wanted = {cia.ABORT_CONNECTION: ("lost host", cia.DISABLE_VOLTAGE)}
    wanted |= {index: (name, 0) for index, name in cia.TORQUE_OFF.items()}
    for index, (name, value) in wanted.items():
        entry = Object(index, 0, 2)
        if not drive.has(entry):
            if index == cia.HALT:
                continue
            raise DeviceError(
                f"CiA 402 drive {drive.number} has no option code for '{name}' ({entry}): nobody "
                "knows whether its torque is off then"
            )
        try:
            drive.write(entry, value)
        except DeviceError as error:
            raise DeviceError(
                f"CiA 402 drive {drive.number} does not take its torque off on '{name}' "
                f"({entry} = {value}): {error}"
            ) from error


def _choose_mode(drive: Remote, mode: int | None) -> None:
    offered = drive.read(Object(cia.MODES, 0, 4))
    found = [m for m in (cia.CYCLIC_TORQUE, cia.PROFILE_TORQUE) if offered >> (m - 1) & 1]
    chosen = next((m for m in found if mode in (None, m)), None)
    if chosen is None:
        wanted = "torque mode (10 or 4)" if mode is None else f"mode {mode}"
        raise DeviceError(
            f"CiA 402 drive {drive.number} has no {wanted}: it offers 0x{offered:08x} (6502h)"
        )
    if chosen == cia.PROFILE_TORQUE:
        drive.write(Object(cia.SLOPE, 0, 4), cia.FASTEST)
    drive.write(Object(cia.MODE, 0, 1), chosen)
    shown = Object(cia.MODE_SHOWN, 0, 1)
    if not any(drive.read(shown) == chosen for _ in range(MODE_TRIES)):
        raise DeviceError(f"CiA 402 drive {drive.number} does not go into mode {chosen} ({shown})")


def _compare_counts(drive: Remote, counts: int) -> None:
    """With the device file, where the drive says how far it counts."""
    entry = Object(cia.RESOLUTION, cia.ENCODER, 4)
    if not drive.has(entry):
        return
    turns = drive.read(Object(cia.RESOLUTION, cia.ENCODER_TURNS, 4))
    found = drive.read(entry)
    if found != counts * turns:
        raise DeviceError(
            f"CiA 402 drive {drive.number} counts {found} in {turns} turns ({entry}), the device "
            f"file says {counts} a turn: correct 'counts_per_turn' there"
        )


def _rated(drive: Remote) -> float:
    found = drive.read(Object(cia.RATED, 0, 4))
    if found == 0:
        raise DeviceError(
            f"CiA 402 drive {drive.number} knows no rated torque (6076h is 0): give it one with "
            "its maker's tool; every torque is in thousandths of it"
        )
    return found * 1e-3


def _try_timer(drive: Remote, milliseconds: int) -> None:
    """Whether the drive can time our commands; it does from activation on."""
    entry, _ = rpdo_timer()
    if not drive.has(entry):
        raise DeviceError(
            f"CiA 402 drive {drive.number} cannot time our commands (no {entry}): write "
            "'settings: {rpdo_timer: false}' to rely on its watching our heartbeat alone"
        )
    identifier = Object(Index.RPDO, 1, 4)
    name = drive.read(identifier)
    drive.write(identifier, name | wire.INVALID)
    drive.write(entry, milliseconds)
    drive.write(entry, 0)
    drive.write(identifier, name)
