"""Nodes outside the loop, through the PyPI package ``canopen``: all that is written is read back.

The package reads the bus in a thread of its own; that thread has ended when ``network`` returns.
"""

from __future__ import annotations

import threading
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from hil.device.errors import DeviceError
from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.protocol import Index, NmtCommand, Object
from hil.wire.can_bus import CanBus

NOT_THERE = {0x06020000, 0x06090011}
"""SDO abort codes: no such object, no such sub-index."""
NO_REMOTE = 1 << 30
"""Bit of a COB-ID entry that some devices insist on: no remote frames."""
SPARE_PDOS = 4
"""Transmit PDOs of the pre-defined connection set; all but the first are switched off."""
NOTIFIER_SECONDS = 0.005
"""How long the package's thread may take to notice that it is to end."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CanopenTiming:
    """Supervision both ways, and how long a node may take to answer."""

    heartbeat_ms: int
    """How often each node says that it is alive."""
    watchdog_ms: int
    """After how long without our heartbeat a node with outputs takes its error values."""
    producer: int
    """The node number of our heartbeat."""
    timeout: float
    """For one SDO answer, or a boot-up (s)."""


class Remote:
    """One node, through the package's SDO client and NMT."""

    def __init__(self, its: Any, number: int, timeout: float, bus: str) -> None:
        import canopen

        self.number, self._timeout, self._bus = number, timeout, bus
        self._node: Any = canopen.RemoteNode(number, canopen.ObjectDictionary())
        self._node.sdo.RESPONSE_TIMEOUT = timeout
        self._booted = threading.Event()
        its.add_node(self._node)
        its.subscribe(wire.heartbeat_id(number), self._heard)

    def reset_communication(self) -> None:
        """Bring the node into its power-on setting; positions stay.

        Raises:
            DeviceError: it does not boot.
        """
        self._reset(NmtCommand.RESET_COMMUNICATION)

    def reset_node(self) -> None:
        """As if it had been switched off and on.

        Raises:
            DeviceError: it does not boot.
        """
        self._reset(NmtCommand.RESET)

    def _reset(self, command: NmtCommand) -> None:
        self._booted.clear()
        self._node.nmt.send_command(command)
        if not self._booted.wait(self._timeout):
            raise DeviceError(
                f"CANopen node {self.number} does not answer on {self._bus}: look at its supply, "
                "node number, bit rate and the bus's two terminating resistors"
            )

    def start(self) -> None:
        """Into Operational."""
        self._node.nmt.send_command(NmtCommand.START)

    def read(self, entry: Object) -> int:
        """An object's value (unsigned).

        Raises:
            DeviceError: the node refuses, or does not answer.
        """
        data = self._ask(f"reading {entry}", "upload", entry.index, entry.subindex)
        return int.from_bytes(data[: entry.size], "little")

    def write(self, entry: Object, value: int) -> None:
        """Write an object, read it back and compare.

        Raises:
            DeviceError: the node refuses, does not answer, or did not keep the value.
        """
        value &= (1 << 8 * entry.size) - 1
        data = value.to_bytes(entry.size, "little")
        self._ask(f"writing {value:#x} to {entry}", "download", entry.index, entry.subindex, data)
        kept = self.read(entry)
        if kept != value:
            raise DeviceError(
                f"CANopen node {self.number} did not keep {entry}: {value:#x} was written, "
                f"{kept:#x} is read back"
            )

    def has(self, entry: Object) -> bool:
        """Whether the node has an object."""
        import canopen

        try:
            self._node.sdo.upload(entry.index, entry.subindex)
        except canopen.SdoAbortedError as error:
            return error.code not in NOT_THERE
        except canopen.SdoCommunicationError as error:
            raise DeviceError(f"CANopen node {self.number} falls silent: {error}") from error
        return True

    def _ask(self, doing: str, call: str, *arguments: Any) -> bytes:
        import canopen

        try:
            return getattr(self._node.sdo, call)(*arguments) or b""
        except (canopen.SdoAbortedError, canopen.SdoCommunicationError) as error:
            raise DeviceError(f"CANopen node {self.number}, {doing}: {error}") from error

    def _heard(self, _identifier: int, data: bytearray, _time: float) -> None:
        if bytes(data[:1]) == b"\0":
            self._booted.set()


@contextmanager
def network(bus: CanBus) -> Generator[Any]:
    """The package's network on a bus that stays open; its thread has ended afterwards."""
    import canopen

    before = threading.active_count()
    with bus.for_set_up() as raw:
        made: Any = canopen.Network(raw)
        made.NOTIFIER_CYCLE = NOTIFIER_SECONDS
        made.connect()
        try:
            yield made
        finally:
            made.notifier.stop()
    bus.resume()
    if threading.active_count() > before:
        raise DeviceError(f"the thread that set up the nodes on {bus.name} does not end")


def refuse_errors(node: Remote) -> None:
    """Refuse a node that reports an error after its reset.

    Raises:
        DeviceError: it does.
    """
    register = node.read(Object(Index.ERROR_REGISTER, 0, 1))
    if register:
        raise DeviceError(
            f"CANopen node {node.number} reports an error (register 0x{register:02x}) after its "
            "reset: switch it off and on, and look at its manual if that does not help"
        )


def silence_spare_pdos(node: Remote) -> None:
    """Nothing but what was asked for, because the bus's load is computed from that."""
    for number in range(1, SPARE_PDOS):
        entry = Object(Index.TPDO + number, 1, 4)
        if node.has(entry):
            node.write(entry, node.read(entry) | wire.INVALID)


def map_pdo(
    node: Remote, parameters: Index, identifier: int, kind: int, objects: list[Object]
) -> None:
    """Map objects to a PDO in the order that CiA 301 asks for."""
    mapping = parameters + Index.TPDO_MAPPING - Index.TPDO
    name, count = Object(parameters, 1, 4), Object(mapping, 0, 1)
    identifier |= node.read(name) & NO_REMOTE
    node.write(name, identifier | wire.INVALID)
    node.write(Object(parameters, 2, 1), kind)
    node.write(count, 0)
    for number, entry in enumerate(objects, start=1):
        value = wire.mapping(entry.index, entry.subindex, 8 * entry.size)
        node.write(Object(mapping, number, 4), value)
    node.write(count, len(objects))
    node.write(name, identifier)


def try_watchdog(node: Remote, timing: CanopenTiming) -> None:
    """Whether the node can watch us; it begins to when the device is activated."""
    entry = Object(Index.HEARTBEAT_CONSUMER, 1, 4)
    node.write(entry, wire.consumer(timing.producer, timing.watchdog_ms))
    node.write(entry, 0)


def serial_of(node: Remote) -> str | None:
    """Its serial number, where it has one."""
    entry = Object(Index.IDENTITY, 4, 4)
    return str(node.read(entry)) if node.has(entry) else None
