"""Clients that nobody here wrote: the maker's Haply library, and ODrive's messages as a DBC."""

from __future__ import annotations

import subprocess
import sys
from math import degrees
from pathlib import Path

import cantools
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.drivers.odrive import protocol as wire
from hil.drivers.odrive.emulator import OdriveBoard
from hil.drivers.odrive.protocol import OdriveCommand, identifier
from hil.emulation.board import BoardFrame
from hil.emulation.world import World
from tests.support.hil.driver_bench import Bench

CLIENT = """
import sys
from HaplyHAPI import Board, Device, Pantograph
board = Board("test", sys.argv[1], 0)
device = Device(5, board)
device.set_mechanism(Pantograph(3))
device.add_actuator(1, 1, 2)
device.add_actuator(2, 1, 1)
device.add_encoder(1, 1, 168.0, 4880, 2)
device.add_encoder(2, 1, 12.0, 4880, 1)
device.device_set_parameters()
for _ in range(50):
    device.set_device_torques([0.0, 0.5])
    device.device_write_torques()
    while not device._Device__deviceLink.data_available():
        pass
    device.device_read_data()
    angles = device.get_device_angles()
    device.get_device_position(angles)
print(*angles)
print(*[motor.get_torque() for motor in device._Device__motors])
"""


def test_the_makers_haply_library_drives_our_emulator(bench: Bench):
    emulator = bench.emulator("haply", lockstep=False)
    port = emulator.url.partition("://")[2].partition("?")[0]
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", CLIENT, port],
        capture_output=True,
        text=True,
        check=True,
    )
    angles, torques = ([float(v) for v in line.split()] for line in done.stdout.splitlines())
    state = emulator.control.ask("state")
    # Joint 1 is on port 2 here as in the maker's example; the wire has the order of the ports, and
    # the maker's library turns it back.
    turned = [degrees(state["angle"][i] - emulator.home[i]) for i in (0, 1)]
    assert angles == pytest.approx([168.0 + turned[0], 12.0 + turned[1]], abs=1.0)
    bounded = [max(-0.123, min(0.123, torque)) for torque in torques]
    assert state["torque"] == pytest.approx(bounded, abs=1e-6)
    assert any(state["torque"]), "the client has to have pushed"


DATABASE = cantools.database.load_file(Path(__file__).parents[2] / "support" / "hil" / "odrive.dbc")
torque = st.floats(-100, 100, width=32)


@settings(deadline=None)
@given(st.integers(0, 1), torque)
def test_the_dbc_reads_the_torques_that_the_driver_sends(node, value):
    message = DATABASE.get_message_by_name(f"Axis{node}_Set_Input_Torque")
    assert message.frame_id == identifier(node, OdriveCommand.SET_TORQUE)
    data = wire.set_torque(value)
    assert message.decode(data.ljust(message.length, b"\0"))["Input_Torque"] == value


@settings(deadline=None)
@given(st.integers(0, 1), torque, torque)
def test_the_driver_reads_estimates_that_the_dbc_encodes(node, position, velocity):
    message = DATABASE.get_message_by_name(f"Axis{node}_Get_Encoder_Estimates")
    data = message.encode({"Pos_Estimate": position, "Vel_Estimate": velocity})
    assert message.frame_id == identifier(node, OdriveCommand.ESTIMATES)
    assert wire.estimates(data) == (position, velocity)


def test_every_frame_of_the_emulator_is_in_the_dbc():
    class Still:
        def angle(self):
            return 0.5, 0.25

        def step(self, torque):
            pass

    board = OdriveBoard(World(Still(), lockstep=False))
    for name, signals in (
        ("Set_Axis_State", {"Axis_Requested_State": 8}),
        ("Set_Input_Torque", {"Input_Torque": 0.25}),
    ):
        for node in (0, 1):
            message = DATABASE.get_message_by_name(f"Axis{node}_{name}")
            board.receive(BoardFrame(message.frame_id, message.encode(signals)))
    assert board.world.torque == (0.25, 0.25)
    frames = [frame for _ in range(10) for frame in board.tick()]
    decoded = {
        message.name: message.decode(frame.data)
        for frame in frames
        for message in [DATABASE.get_message_by_frame_id(frame.identifier)]
    }
    assert decoded["Axis0_Heartbeat"]["Axis_State"] == 8
    assert decoded["Axis0_Get_Encoder_Estimates"]["Pos_Estimate"] == pytest.approx(
        0.5 / 6.2831853, abs=1e-4
    )
