"""Two emulated CiA 402 drives on CAN that move a simulated pantograph."""

from __future__ import annotations

from hil.drivers.canopen.emulator import NodesBoard
from hil.drivers.cia402.emulated_drive import EmulatedDrive
from hil.emulation.launch import Made, Order, on_can
from hil.emulation.world import World


class DrivesBoard(NodesBoard):
    """A drive a joint."""

    def __init__(
        self, world: World, *, nodes: tuple[int, ...] = (1, 2), tick: float = 1 / 1024
    ) -> None:
        super().__init__(
            world,
            lambda wire, world: {
                number: EmulatedDrive(number, joint, wire, world)
                for joint, number in enumerate(nodes)
            },
            tick=tick,
        )


def make(order: Order, world: World) -> Made:
    """Two drives on a CAN link."""
    nodes = tuple(order.options.get("nodes", (1, 2)))
    board = DrivesBoard(world, nodes=nodes, tick=order.tick)
    found, link, url = on_can("cia402", order, board, board.owns)
    joined = "&" if "?" in url else "?"
    return found, link, f"{url}{joined}nodes={','.join(str(node) for node in nodes)}"
