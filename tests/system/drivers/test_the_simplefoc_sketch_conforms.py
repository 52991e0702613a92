"""The SimpleFOC sketch, compiled for this machine and run behind the wire, keeps every rule."""

from __future__ import annotations

import ctypes
from functools import partial
from pathlib import Path

import pytest

from hil.safety.permission import emulated
from hil.setup.address import parse
from hil.setup.calibrate.turner import EmulatedTurner
from hil.setup.conform.bench import ConformBench
from hil.setup.conform.rule import Conformity
from hil.setup.conform.suite import conform
from hil.setup.device_file import parse as parse_file
from hil.setup.registry import find
from tests.support.hil.board_process import board_process
from tests.support.hil.driver_bench import PROOF, firmware
from tests.support.hil.sketch_board import COUNTS, SketchBoard, build_sketch

JOINT = {"counts_per_turn": COUNTS}


@pytest.fixture(scope="module")
def sketch(tmp_path_factory) -> Path:
    return build_sketch(tmp_path_factory.mktemp("sketch"))


def test_the_sketch_keeps_every_rule(sketch):
    with board_process(partial(SketchBoard, library=str(sketch))) as board:
        bench = ConformBench(
            kind=find("cobs"),
            address=parse(board.url),
            file=parse_file(
                {
                    "driver": "cobs",
                    "home": list(board.home),
                    "joints": [JOINT, JOINT],
                    "watchdog_proof": PROOF,
                }
            ),
            turner=EmulatedTurner(str(board.control.path)),
            ask=None,
            control=board.control,
            permission=emulated(board.url, None),
            seconds=0.5,
        )
        results = list(conform(bench))
    broken = [result for result in results if result.outcome is Conformity.BROKEN]
    # A switch that no pin is wired to is never closed.
    assert [result.name for result in broken] == ["switch"], broken
    assert all(result.outcome is Conformity.KEPT for result in results if result not in broken)


def test_a_command_that_came_after_the_clock_was_read_fires_no_watchdog():
    """An interrupt takes a byte between the reading of the clock and the look at the watchdog."""
    library = ctypes.CDLL(firmware())
    library.device_receive.restype = ctypes.c_size_t
    device, reply = (ctypes.c_uint8 * 256)(), (ctypes.c_uint8 * 24)()
    count = (ctypes.c_int32 * 2)()
    library.device_init(device)
    from hil.drivers.cobs.protocol import CommandFlag, ReplyFlag, command
    from hil.drivers.cobs.protocol import reply as read
    from hil.wire.cobs_frames import Splitter

    def exchange(now: int) -> ReplyFlag:
        flags = CommandFlag.ENABLE
        for byte in command(flags, 1, (0.01, 0.0), 20):
            size = library.device_receive(
                device, ctypes.c_uint8(byte), ctypes.c_uint32(now), count, reply
            )
        (body,) = Splitter().feed(bytes(reply)[:size])
        found = read(body)
        assert found is not None
        return found.status

    exchange(1_000)
    library.device_tick(device, ctypes.c_uint32(990))
    assert exchange(1_100) & ReplyFlag.ENABLED
    library.device_tick(device, ctypes.c_uint32(1_100 + 20_001))
    assert exchange(22_000) & ReplyFlag.WATCHDOG_FIRED
