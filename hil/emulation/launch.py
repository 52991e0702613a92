"""Starting an emulator: choose board and link by name, say under which URL it is reached."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import socket
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Self

from cosim.base.errors import InputError
from hil.emulation.board import Board
from hil.emulation.links import CanLink, Link, PtyLink, SlcanLink
from hil.emulation.plant import Hand, SimulatedPantograph
from hil.emulation.server import Server
from hil.emulation.side_channel import Control
from hil.emulation.world import World
from hil.realtime.system import freeze_garbage, real_time_priority

PATIENCE = 600.0
"""Seconds to wait for an emulator's first word; one that dies is noticed at once."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """What to emulate; everything in it can be sent to another process."""

    name: str
    lockstep: bool = False
    tick: float = 1 / 1024
    parameters: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """The simulated pantograph's parameters."""
    hand: Mapping[str, float] = field(default_factory=dict[str, float])
    """Stiffness (N/m) and damping (N.s/m) of the hand that holds the handle."""
    operator: Mapping[str, Any] | None = None
    """Parameters of the operator FMU that moves the handle once the run starts."""
    priority: int = 0
    """SCHED_FIFO priority, where it is granted; 0 for none."""
    link: str = "pty"
    options: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Of the board or of the bus."""


def make(order: Order) -> tuple[Board, Link, str]:
    """Board, link and URL of an emulator.

    Raises:
        InputError: there is no emulator of that name, or it has no such link.
    """
    if order.name not in BOARDS:
        raise InputError(
            f"there is no emulator '{order.name}'; there are {', '.join(sorted(BOARDS))}"
        )
    body = SimulatedPantograph(
        order.parameters, hand=Hand(**order.hand), operator=order.operator, step=order.tick
    )
    return BOARDS[order.name](order, World(body, lockstep=order.lockstep))


def _haply(_: Order, world: World) -> tuple[Board, Link, str]:
    from hil.drivers.haply.emulator import HaplyBoard

    link = PtyLink()
    return HaplyBoard(world), link, f"haply://{link.path}"


def _odrive(order: Order, world: World) -> tuple[Board, Link, str]:
    from hil.drivers.odrive.emulator import OdriveBoard

    board = OdriveBoard(world, tick=order.tick, **order.options)
    return _on_can("odrive", order, board, board.owns)


def _cobs(order: Order, world: World) -> tuple[Board, Link, str]:
    from hil.drivers.cobs.emulator import CobsBoard, FirmwareBoard

    link = PtyLink()
    kind = FirmwareBoard if "firmware" in order.options else CobsBoard
    return kind(world, tick=order.tick, **order.options), link, f"cobs://{link.path}"


def _canopen(order: Order, world: World) -> tuple[Board, Link, str]:
    from hil.drivers.canopen.emulator import CanopenBoard

    options = {**order.options, "nodes": tuple(order.options.get("nodes", (1,)))}
    board = CanopenBoard(world, tick=order.tick, **options)
    found, link, url = _on_can("canopen", order, board, board.owns)
    joined = "&" if "?" in url else "?"
    return found, link, f"{url}{joined}nodes={','.join(str(node) for node in options['nodes'])}"


def _on_can(
    name: str, order: Order, board: Board, owns: Callable[[int], bool]
) -> tuple[Board, Link, str]:
    """The link of a board on CAN: ``slcan`` on a pty, or a multicast group of its own."""
    if order.link == "slcan":
        link = SlcanLink()
        return board, link, f"{name}+slcan://{link.path}?sleep_after_open=0"
    if order.link not in {"pty", "udp_multicast"}:
        raise InputError(f"a CAN emulator has the links slcan and udp_multicast, not {order.link}")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        port: int = probe.getsockname()[1]
    group = f"239.74.163.{2 + os.getpid() % 250}"
    bus = CanLink(owns, interface="udp_multicast", channel=group, port=port, hop_limit=0)
    return board, bus, f"{name}+udp_multicast://{group}:{port}"


BOARDS: dict[str, Callable[[Order, World], tuple[Board, Link, str]]] = {
    "canopen": _canopen,
    "cobs": _cobs,
    "haply": _haply,
    "odrive": _odrive,
}


def serve(
    order: Order,
    folder: Path,
    report: Callable[[dict[str, Any]], None],
    owner: Connection | None = None,
) -> None:
    """Run an emulator in this process until it is told to stop; ``report`` gets its URL.

    It also ends when the other end of ``owner`` is closed, because whoever started it has died.
    """
    board, link, url = make(order)
    if order.priority:
        freeze_garbage()
        real_time_priority(order.priority)
    path = folder / "control"
    server = Server(board, link, path, tick=order.tick, owner=owner)
    joined = "&" if "?" in url else "?"
    url += f"{joined}emulator={path}" + ("&lockstep=1" if order.lockstep else "")
    report({"url": url, "control": str(path), "home": board.world.body.angle(), "pid": os.getpid()})
    try:
        server.run()
    finally:
        board.world.body.close()


def _child(order: Order, folder: str, pipe: Connection) -> None:
    try:
        serve(order, Path(folder), pipe.send, pipe)
    except Exception as error:
        pipe.send({"error": f"{type(error).__name__}: {error}"})
        raise


class Emulator:
    """An emulator in a process of its own, with its side channel."""

    def __init__(self, order: Order, *, method: str = "forkserver") -> None:
        context: Any = multiprocessing.get_context(method)
        self._folder = tempfile.mkdtemp(prefix="cohaptic-")
        self._lifeline, theirs = context.Pipe()
        self._process: Any = context.Process(
            target=_child, args=(order, self._folder, theirs), daemon=True
        )
        self._process.start()
        theirs.close()
        try:
            said: dict[str, Any] = (
                self._lifeline.recv()
                if self._lifeline.poll(PATIENCE)
                else {"error": "it says nothing"}
            )
        except EOFError:
            said = {"error": "it died at once"}
        if "error" in said:
            self._end()
            raise InputError(f"the emulator '{order.name}' did not start: {said['error']}")
        self.url: str = said["url"]
        self.home: tuple[float, float] = said["home"]
        self.control = Control(said["control"])

    def wait(self) -> None:
        """Return once it has ended."""
        self._process.join()

    def close(self) -> None:
        """Stop it and remove its folder."""
        try:
            self.control.ask("stop")
        except Exception:
            self._process.terminate()
        self.control.close()
        self._end()

    def _end(self) -> None:
        self._lifeline.close()
        self._process.join(5)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._process.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
