"""Starting an emulator: find its board by the driver's name, say under which URL it is reached."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import socket
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Self

from cosim.base.errors import InputError
from cosim.base.system.grants import freeze_garbage, real_time_priority
from hil.emulation.board import Board
from hil.emulation.links import CanLink, HostLink, PtyLink, SlcanLink
from hil.emulation.mechanics import Mechanics
from hil.emulation.plant import Hand, SimulatedPantograph
from hil.emulation.server import Server
from hil.emulation.world import World
from hil.setup.registry import find, names
from hil.wire.side_channel import Control

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
    mechanics: Mechanics = field(default_factory=Mechanics)
    """What the pantograph is made of, over ``parameters`` and ``hand``."""
    priority: int = 0
    """SCHED_FIFO priority, where it is granted; 0 for none."""
    link: str = "pty"
    options: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Of the board or of the bus."""


Made = tuple[Board, HostLink, str]
"""An emulated board, its link, and the URL under which a host reaches it."""


def make(order: Order) -> Made:
    """Board, link and URL of an emulator, as the driver of that name declares it.

    Raises:
        InputError: there is no driver of that name, it has no emulator, or that has no such link.
    """
    module, _, name = _maker(order.name).partition(":")
    board = getattr(import_module(module), name)
    mechanics = order.mechanics
    hand = mechanics.held(Hand(**order.hand))
    # The pantograph carries a hand's mass at its tip unless it is told otherwise.
    held = hand.is_there or order.operator is not None
    unheld: dict[str, Any] = {} if held else {"finger_mass": 0.0}
    body = SimulatedPantograph(
        {**unheld, **order.parameters, **mechanics.parameters},
        hand=hand,
        operator=order.operator,
        step=order.tick,
        gain=mechanics.gain,
        noise=mechanics.noise,
    )
    return board(order, World(body, lockstep=order.lockstep))


def _maker(name: str) -> str:
    kind = find(name)
    if kind.emulator is None:
        emulated = [each for each in names() if find(each).emulator is not None]
        raise InputError(
            f"there is no emulator of '{name}'; there are some of {', '.join(emulated)}"
        )
    return kind.emulator


def on_terminal(order: Order) -> PtyLink:
    """The link of a board on a serial port: a pseudo-terminal.

    Raises:
        InputError: another one was asked for.
    """
    if order.link != "pty":
        raise InputError(f"the emulator '{order.name}' has the link pty, not {order.link}")
    return PtyLink()


def on_can(name: str, order: Order, board: Board, owns: Callable[[int], bool]) -> Made:
    """A board on CAN with its link: ``slcan`` on a pty, or a multicast group of its own.

    Raises:
        InputError: there is no such link.
    """
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
    home = order.mechanics.homed(board.world.body.angle())
    report({"url": url, "control": str(path), "home": home, "pid": os.getpid()})
    try:
        server.run()
    finally:
        board.world.body.close()


def _child(order: Order, folder: str, pipe: Connection) -> None:
    try:
        serve(order, Path(folder), pipe.send, pipe)
    except InputError as error:
        pipe.send({"error": error.message})
    except Exception as error:
        pipe.send({"error": f"{type(error).__name__}: {error}"})
        raise


class Emulator:
    """An emulator in a process of its own, with its side channel."""

    def __init__(self, order: Order, *, method: str = "forkserver") -> None:
        _maker(order.name)  # refused here, and not in the other process
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
