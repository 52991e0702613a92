"""A board of a test's own behind ``cobs``, served in a process of its own as an emulator is."""

from __future__ import annotations

import multiprocessing
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from hil.emulation import launch
from hil.emulation.board import Board
from hil.emulation.launch import Order
from hil.emulation.plant import Hand, SimulatedPantograph
from hil.emulation.world import World
from hil.wire.side_channel import Control
from tests.support.scratch import scratch_folder

QUANSER = {"initial_tip_position": (0.0425, 0.2)}


@contextmanager
def board_process(kind: Callable[..., Board]) -> Iterator[SimpleNamespace]:
    """``url``, ``home`` and ``control`` of the board that ``kind(world, tick=...)`` makes."""
    context: Any = multiprocessing.get_context("forkserver")
    folder = str(scratch_folder("board"))
    lifeline, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(kind, folder, theirs), daemon=True)
    process.start()
    theirs.close()
    said = lifeline.recv()
    control = Control(said["control"])
    try:
        yield SimpleNamespace(url=said["url"], home=said["home"], control=control)
    finally:
        control.close()
        lifeline.close()
        process.join(10)
        shutil.rmtree(folder, ignore_errors=True)


def _serve(kind: Callable[..., Board], folder: str, pipe: Any) -> None:
    def made(order: Order) -> launch.Made:
        body = SimulatedPantograph(order.parameters, hand=Hand(), step=order.tick)
        link = launch.on_terminal(order)
        world = World(body, lockstep=order.lockstep)
        return kind(world, tick=order.tick), link, f"cobs://{link.path}"

    launch.make = made  # this process ends with it
    order = Order(name="cobs", lockstep=True, parameters=QUANSER)
    launch.serve(order, Path(folder), pipe.send, pipe)
