"""Two ODrive axes as their host sees them on CAN, with the watchdog that any frame feeds."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from math import isfinite, pi

from hil.device.contract import ZERO
from hil.drivers.odrive.protocol import (
    CLOSED_LOOP,
    DEVICE_COMMANDS,
    IDLE,
    WATCHDOG_EXPIRED,
    OdriveCommand,
    identifier,
)
from hil.emulation.board import Board, BoardFrame, Unit
from hil.emulation.faults import FaultKind
from hil.emulation.launch import Made, Order, on_can
from hil.emulation.world import World

HEARTBEAT_TICKS = 10
LONGEST_WATCHDOG = 60.0
WATCHDOG_TIMEOUT, WATCHDOG_ENABLE = 0x0101, 0x0102
"""Endpoint numbers of this emulator; a real one's depend on its firmware."""


@dataclass
class OdriveAxis:
    """One axis."""

    state: int = IDLE
    error: int = 0
    torque: float = 0.0
    watchdog_ticks: int | None = None
    """How long it lives without a frame; ``None``: the watchdog is off."""
    enabled: bool = False
    silence: int = 0
    commanded: bool = field(default=False)
    """Whether a torque has come in this tick."""


class OdriveBoard(Board):
    """Nodes with one motor each; joint i is on ``nodes[i]``."""

    def __init__(
        self,
        world: World,
        nodes: tuple[int, int] = (0, 1),
        counts_per_turn: int = 8192,
        tick: float = 1 / 1024,
    ) -> None:
        super().__init__(world)
        self._nodes = nodes
        self._counts = counts_per_turn
        self._tick = tick
        self._axes = {node: OdriveAxis() for node in nodes}
        self._age = 0
        self._estimated = False

    def owns(self, identifier_: int) -> bool:
        """Whether a frame is one that an axis sends."""
        return identifier_ & 0x1F in DEVICE_COMMANDS

    def receive(self, unit: Unit) -> list[Unit]:
        """Take one frame; a torque for both axes ends the tick."""
        assert isinstance(unit, BoardFrame)
        axis = self._axes.get(unit.identifier >> 5)
        if axis is None:
            return []
        axis.silence = 0
        try:
            self._command(axis, unit.identifier & 0x1F, unit.data)
        except (struct.error, IndexError):
            return []  # not as long as its command needs
        self._apply()
        if not all(axis.commanded for axis in self._axes.values()):
            return []
        for each in self._axes.values():
            each.commanded = False
        if not self.world.lockstep:
            return []
        answers = self._estimates()
        self._estimated = True
        self.world.boundary()
        return answers

    def tick(self) -> list[Unit]:
        """Watchdogs, heartbeats, and estimates where no torque brought them."""
        if self.world.fault(FaultKind.RESTART):
            self._axes = {node: OdriveAxis() for node in self._nodes}
        for axis in self._axes.values():
            axis.silence += 1
            limit = axis.watchdog_ticks
            if axis.enabled and limit is not None and axis.silence > limit:
                axis.error |= WATCHDOG_EXPIRED["0.6"]
                axis.state, axis.torque = IDLE, 0.0
        self._apply()
        frames: list[Unit] = [] if self._estimated else self._estimates()
        self._estimated = False
        self._age += 1
        if self._age % HEARTBEAT_TICKS == 0:
            frames += [
                BoardFrame(
                    identifier(node, OdriveCommand.HEARTBEAT),
                    struct.pack("<IBBBB", axis.error, axis.state, 0, 0, 0),
                )
                for node, axis in self._axes.items()
            ]
        return frames

    def _command(self, axis: OdriveAxis, command: int, data: bytes) -> None:
        match command:
            case OdriveCommand.ESTOP:
                axis.state, axis.torque = IDLE, 0.0
            case OdriveCommand.SET_STATE:
                (wanted,) = struct.unpack("<I", data)
                if wanted in {IDLE, CLOSED_LOOP}:
                    axis.state = IDLE if axis.error else wanted
            case OdriveCommand.SET_TORQUE:
                (torque,) = struct.unpack("<f", data)
                axis.torque, axis.commanded = torque if isfinite(torque) else 0.0, True
            case OdriveCommand.CLEAR_ERRORS:
                axis.error = 0
            case OdriveCommand.WRITE_ENDPOINT:
                self._write(axis, data)
            case _:
                pass

    def _write(self, axis: OdriveAxis, data: bytes) -> None:
        _, endpoint, _ = struct.unpack_from("<BHB", data)
        if endpoint == WATCHDOG_TIMEOUT:
            (seconds,) = struct.unpack_from("<f", data, 4)
            if 0.0 < seconds < LONGEST_WATCHDOG:
                axis.watchdog_ticks = max(1, round(seconds / self._tick))
        elif endpoint == WATCHDOG_ENABLE:
            axis.enabled = bool(data[4])

    def _apply(self) -> None:
        first, second = (
            axis.torque if axis.state == CLOSED_LOOP else 0.0 for axis in self._axes.values()
        )
        self.world.torque = (first, second) if (first, second) != ZERO else ZERO

    def _estimates(self) -> list[Unit]:
        frames: list[Unit] = []
        for node, angle in zip(self._nodes, self.world.angle(), strict=True):
            turns = round(angle / (2 * pi) * self._counts) / self._counts
            frames.append(
                BoardFrame(
                    identifier(node, OdriveCommand.ESTIMATES), struct.pack("<ff", turns, 0.0)
                )
            )
        return frames


def make(order: Order, world: World) -> Made:
    """Two axes on a CAN link."""
    board = OdriveBoard(world, tick=order.tick, **order.options)
    return on_can("odrive", order, board, board.owns)
