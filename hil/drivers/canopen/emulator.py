"""CANopen nodes with encoders (CiA 406) and analogue outputs (CiA 401), as a master sees them."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Callable, Mapping

from canopen.sdo.exceptions import SdoError

from hil.drivers.canopen.emulated_local import LocalWire
from hil.drivers.canopen.emulated_mapping import MappedNode
from hil.drivers.canopen.emulated_node import Axes, EmulatedNode
from hil.emulation.board import Board, BoardFrame, Unit
from hil.emulation.faults import FaultKind
from hil.emulation.launch import Made, Order, on_can
from hil.emulation.world import World

SYNC = 0x080
HARDWARE, HARDWARE_ERROR = 0x5000, 0x81
"""Emergency and error register (generic and manufacturer specific) of an alarm."""


def axes(nodes: tuple[int, ...]) -> dict[int, Axes]:
    """One node with both joints, one a joint, or two encoders and a node with both outputs."""
    match nodes:
        case (both,):
            return {both: Axes({(0x6020, 1): 0, (0x6020, 2): 1}, {1: 0, 2: 1})}
        case (first, second):
            return {
                first: Axes({(0x6004, 0): 0}, {1: 0}),
                second: Axes({(0x6004, 0): 1}, {1: 1}),
            }
        case _:
            first, second, outputs = nodes
            return {
                first: Axes({(0x6004, 0): 0}),
                second: Axes({(0x6004, 0): 1}),
                outputs: Axes({}, {1: 0, 2: 1}),
            }


class NodesBoard(Board):
    """Everything of ours on the bus, whatever the nodes' profile: ``made`` makes them."""

    def __init__(
        self,
        world: World,
        made: Callable[[LocalWire, World], Mapping[int, MappedNode]],
        *,
        tick: float = 1 / 1024,
    ) -> None:
        super().__init__(world)
        self._wire, self._tick, self._time = LocalWire(), tick, 0.0
        self._nodes = made(self._wire, world)
        self._wire.taken()  # nobody was there to see the nodes boot
        self._had: set[int] = set()

    def owns(self, identifier: int) -> bool:
        """Whether a frame is one that a node sends."""
        function, node = identifier & ~0x7F, identifier & 0x7F
        return node in self._nodes and function in {0x080, 0x180, 0x280, 0x580, 0x700}

    def receive(self, unit: Unit) -> list[Unit]:
        """Take one frame; SYNC ends the tick."""
        assert isinstance(unit, BoardFrame)
        if unit.identifier == SYNC:
            self.world.boundary()
            answers = [frame for node in self._nodes.values() for frame in node.sync()]
        else:
            self._take(unit)
            answers = self._wire.taken()
        self._apply()
        return answers

    def tick(self) -> list[Unit]:
        """Heartbeats out, heartbeats missed, and what goes wrong by itself."""
        self._time += self._tick
        for node in self._nodes.values():
            node.listen(self._time)
        self._misbehave()
        self._wire.periodic = [each for each in self._wire.periodic if not each.stopped]
        for each in self._wire.periodic:
            each.due = each.due or self._time
            if self._time >= each.due:
                each.due += each.period
                self._wire.frames.append(BoardFrame(each.identifier, each.data))
        self._apply()
        return self._wire.taken()

    def _take(self, frame: BoardFrame) -> None:
        function, number = frame.identifier & ~0x7F, frame.identifier & 0x7F
        if function == 0x000 and len(frame.data) == 2:
            self._command(frame)
        elif function == 0x700:
            for node in self._nodes.values():
                node.hear(number, self._time)
        elif function == 0x200 and number in self._nodes:
            self._nodes[number].take(frame.data)
        elif function == 0x600 and len(frame.data) == 8:
            # The package's server stumbles over requests that make no sense; a node stays silent.
            with contextlib.suppress(struct.error, LookupError, ArithmeticError, SdoError):
                self._wire.notify(frame.identifier, bytearray(frame.data), self._time)

    def _command(self, frame: BoardFrame) -> None:
        command, number = frame.data
        for each, node in self._nodes.items():
            if number not in (0, each):
                continue
            if command in (0x81, 0x82):
                node.boot()
            else:
                node.local.nmt.on_command(0, frame.data, self._time)

    def _misbehave(self) -> None:
        for kind in (FaultKind.RESTART, FaultKind.ALARM):
            fault = self.world.fault(kind)
            if fault is None or id(fault) in self._had:
                continue
            self._had.add(id(fault))
            for node in self._nodes.values():
                if kind is FaultKind.RESTART:
                    node.boot()
                else:
                    node.report(HARDWARE, HARDWARE_ERROR)

    def _apply(self) -> None:
        torque = [0.0, 0.0]
        for node in self._nodes.values():
            node.drive()
            for joint, value in node.torque().items():
                torque[joint] = value
        self.world.torque = (torque[0], torque[1])


class CanopenBoard(NodesBoard):
    """Nodes with encoders and analogue outputs."""

    def __init__(
        self, world: World, *, nodes: tuple[int, ...] = (1,), tick: float = 1 / 1024
    ) -> None:
        super().__init__(
            world,
            lambda wire, world: {
                number: EmulatedNode(number, its, wire, world)
                for number, its in axes(nodes).items()
            },
            tick=tick,
        )


def make(order: Order, world: World) -> Made:
    """One to three nodes on a CAN link."""
    options = {**order.options, "nodes": tuple(order.options.get("nodes", (1,)))}
    board = CanopenBoard(world, tick=order.tick, **options)
    found, link, url = on_can("canopen", order, board, board.owns)
    joined = "&" if "?" in url else "?"
    return found, link, f"{url}{joined}nodes={','.join(str(node) for node in options['nodes'])}"
