"""Setting up CANopen nodes before the loop: by the PyPI package ``canopen``, all of it read back.

What the package does is in ``hil.drivers.canopen.remote``.
"""

from __future__ import annotations

from dataclasses import dataclass

from hil.device.errors import DeviceError
from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.layout import CanopenLayout, Encoder, Output
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
from hil.wire.can_bus import CanBus


@dataclass(frozen=True, slots=True)
class Found:
    """What the nodes said of themselves."""

    ranges: tuple[int, int]
    """Measuring range of each encoder (units)."""
    serial: str | None
    """Serial number of the first node that has one."""


def set_up(
    bus: CanBus,
    layout: CanopenLayout,
    timing: CanopenTiming,
    units_per_turn: tuple[int, int],
    zero_codes: tuple[int, int],
) -> Found:
    """Set up every node of a device and start it; outputs are zero.

    ``units_per_turn`` are what the device file expects of each encoder, ``zero_codes`` what gives
    no torque at each output.

    Raises:
        DeviceError: a node does not answer, refuses, does not keep what was written, reports an
            error, or counts otherwise than the device file says.
    """
    with network(bus) as package:
        nodes = {n: Remote(package, n, timing.timeout, bus.name) for n in layout.nodes}
        for node in nodes.values():
            node.reset_communication()
            refuse_errors(node)
            silence_spare_pdos(node)
            node.write(Object(Index.HEARTBEAT_PRODUCER, 0, 2), timing.heartbeat_ms)
        for output, zero in zip(layout.outputs, zero_codes, strict=True):
            _set_up_output(nodes[output.node], output, zero)
        ranges = [
            _range(nodes[encoder.node], encoder, units)
            for encoder, units in zip(layout.encoders, units_per_turn, strict=True)
        ]
        for number in layout.measuring:
            positions = [layout.encoders[j].position for j in layout.joints_measured(number)]
            map_pdo(
                nodes[number], Index.TPDO, wire.positions_id(number), wire.EVERY_SYNC, positions
            )
        for number in layout.driving:
            values = [layout.outputs[j].value for j in layout.joints_driven(number)]
            map_pdo(nodes[number], Index.RPDO, wire.outputs_id(number), wire.AT_ONCE, values)
            try_watchdog(nodes[number], timing)
        serial = next(filter(None, map(serial_of, nodes.values())), None)
        for node in nodes.values():
            node.start()
    return Found((ranges[0], ranges[1]), serial)


def _set_up_output(node: Remote, output: Output, zero: int) -> None:
    """Zero now, and zero on an error (some devices hold their last value by default)."""
    node.write(output.value, zero)
    node.write(output.error_mode, 1)
    node.write(output.error_value, 0)
    behaviour = Object(Index.ERROR_BEHAVIOUR, 1, 1)
    if node.has(behaviour):
        node.write(behaviour, 0)


def _range(node: Remote, encoder: Encoder, units: int) -> int:
    found = node.read(encoder.units_per_turn)
    if found != units:
        raise DeviceError(
            f"CANopen node {node.number} counts {found} a turn ({encoder.units_per_turn}), the "
            f"device file says {units}: correct 'counts_per_turn' there, or the encoder's scaling"
        )
    return node.read(encoder.range) or 1 << 32
