"""What a CANopen node does of its own accord ends in FAULT, and what we do ends in its zero."""

from __future__ import annotations

import struct

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hil.device.contract import State, WriteOutcome
from hil.device.errors import Cause, DeviceError, DeviceFault
from hil.emulation.board import BoardFrame
from hil.safety.permission import emulated
from hil.setup.watchdog_proof import prove_watchdog
from tests.support.hil.canopen_bench import REST, Wire, ready, run
from tests.support.hil.driver_bench import Bench


@pytest.fixture
def wire(request):
    made = Wire(getattr(request, "param", (1, 2, 3)))
    yield made
    made.close()


EVENTS = {
    "boot-up": (0x703, b"\x00", "node 3 has started anew"),
    "stopped": (0x701, b"\x04", "node 1 became stopped"),
    "pre-operational": (0x702, b"\x7f", "node 2 became pre-operational"),
    "no state": (0x702, b"\x33", "one byte with a state"),
    "emergency": (0x083, bytes.fromhex("0050810102030405"), "emergency 0x5000 .*0x81.*01 02 03"),
    "half an emergency": (0x083, b"\x00\x50", "8 bytes, 2 came"),
}


@pytest.mark.parametrize("event", EVENTS)
def test_an_event_is_a_latched_fault_with_its_words(wire, event):
    device = ready(wire.device("1,2,3"))
    identifier, data, words = EVENTS[event]
    wire.inject(identifier, data)
    run(device, 30)
    with pytest.raises(DeviceFault, match=words):
        device.raise_fault()
    assert device.outcome is WriteOutcome.ZERO_CONFIRMED
    assert device.fault.cause is (Cause.BOARD if event == "emergency" else device.fault.cause)
    assert device.homed is (event == "emergency"), "its position is not the one that was homed"
    run(device, 30)
    assert device.state is State.FAULT


def test_an_error_that_is_taken_back_is_none(wire):
    device = ready(wire.device("1,2,3"))
    wire.inject(0x082, bytes(8))
    run(device, 30)
    assert device.state is State.ACTIVE


def test_a_node_of_which_nothing_is_heard_is_missed_though_it_measures_nothing(wire):
    """The node with the outputs sends no positions: its heartbeat is all there is."""
    device = ready(wire.device("1,2,3"))
    wire.deaf.add(3)
    for tick in range(1, 40):
        run(device, 1, tick)
        if device.state is State.FAULT:
            break
    assert tick <= 22, "three heartbeats of 5 ms, and one tick"
    assert "heartbeat of CANopen node 3 has been missing" in device.fault.sentence
    assert not device.homed


def test_frames_of_nodes_that_are_not_ours_change_nothing(wire):
    device = ready(wire.device("1,2,3"))
    for number in (4, 50, 126):
        wire.inject(0x700 + number, b"\x00")
        wire.inject(0x080 + number, b"\x01" * 8)
        wire.inject(0x180 + number, b"\x01" * 8)
    assert run(device, 10).joint_angle == pytest.approx(REST, abs=1e-3)
    assert device.state is State.ACTIVE


def test_activation_arms_the_node_and_deactivation_disarms_it(wire):
    device = ready(wire.device("1,2,3"))
    assert wire.node(3).value(0x1016, 1) == 127 << 16 | 20
    assert wire.node(1).value(0x1016, 1) == 0, "an encoder has nothing to drop"
    assert any(frame.identifier == 0x77F for frame in wire.seen)
    device.deactivate()
    assert wire.node(3).value(0x1016, 1) == 0
    run(device, 60)
    assert device.state is State.INACTIVE, "nobody misses a heartbeat any more"


commands = {0x000, 0x080, 0x201, 0x601, 0x77F}
"""What a node would follow, whoever sent it."""
noise = st.tuples(
    st.one_of(
        st.sampled_from([0x081, 0x181, 0x581, 0x701]),
        st.integers(0, 0x7FF).filter(lambda name: name not in commands),
    ),
    st.binary(max_size=8),
)


@pytest.mark.parametrize("wire", [(1,)], indirect=True)
def test_noise_is_never_a_position_and_the_second_exchange_is_clean(wire):
    device = wire.device()

    @settings(deadline=None, max_examples=60, suppress_health_check=list(HealthCheck))
    @given(st.lists(noise, max_size=8))
    def holds(frames):
        if device.state is State.FAULT:
            device.reset()
        if device.state is State.UNCONFIGURED:
            device.configure()
            device.home()
        for identifier, data in frames:
            wire.inject(identifier, data)
        seen = [run(device, 1, tick) for tick in (0, 1)]
        for measured in seen:
            assert measured.joint_angle == pytest.approx(REST, abs=1e-3), "noise was believed"
        if device.state is State.FAULT:
            assert device.fault_sentence()
            told = {name for name, _ in frames} & {0x081, 0x581, 0x701}
            assert told, f"{device.fault.sentence}: nobody said so"
        else:
            assert seen[-1].sample_age == 0

    holds()


def test_without_our_heartbeat_the_outputs_drop_by_themselves(bench: Bench):
    """The loop stands still: no zero is sent, and the node's own follows in 20 ms."""
    rig = bench.rig("canopen (3 nodes)")
    rig.exchange(500, (0.01, -0.01))
    assert rig.truth()["torque"] != [0.0, 0.0]
    rig.emulator.control.ask("advance", ticks=15)
    assert rig.truth()["torque"] != [0.0, 0.0], "not yet"
    rig.emulator.control.ask("advance", ticks=7)
    assert rig.truth()["torque"] == [0.0, 0.0]
    rig.exchange(5, (0.01, -0.01))
    assert rig.truth()["torque"] == [0.0, 0.0]
    assert "the master's heartbeat is missing" in rig.device.fault.sentence


@pytest.mark.parametrize("name", ["canopen", "canopen (2 nodes)", "canopen (3 nodes)"])
def test_the_watchdog_is_seen_to_fire_and_the_nodes_start_again(name, bench: Bench):
    rig = bench.rig(name, activate=False)
    proof = prove_watchdog(rig.device)
    assert proof.timeout == 0.02
    assert 0.02 <= proof.fired_after + 2 / 1024 <= 0.03, "the last exchange fed it, too"
    assert proof.serial == "4711"
    assert rig.truth()["largest"] == 0.0
    assert rig.device.state is State.INACTIVE
    rig.exchange(60)
    rig.device.activate()
    rig.exchange(500, (0.008, -0.008))
    assert rig.device.state is State.ACTIVE, rig.device.fault_sentence()
    assert rig.truth()["torque"] != [0.0, 0.0]


def test_a_node_that_never_fires_proves_nothing(wire):
    device = wire.device("1,2,3")
    device.configure()
    wire.node(3).listen = lambda now: None
    device.permission = emulated("x", None)
    with pytest.raises(DeviceError, match="did not fire"):
        prove_watchdog(device)


def test_a_node_that_holds_on_an_error_would_have_held(wire):
    """What the zero on error is set up for: without it the same silence leaves the torque."""
    device = ready(wire.device("1,2,3"))
    device.read(0)
    board, node = wire.boards[0], wire.node(3)
    board.receive(BoardFrame(0x203, struct.pack("<2h", 1000, 1000)))
    assert board.world.torque != (0.0, 0.0)
    node.local.set_data(0x6443, 1, b"\0")
    for _ in range(40):
        board.tick()
    assert node.failed
    assert board.world.torque[0] != 0.0
    assert board.world.torque[1] == 0.0


@pytest.mark.parametrize("kind", ["restart", "alarm"])
@pytest.mark.parametrize("name", ["canopen", "canopen (2 nodes)", "canopen (3 nodes)"])
def test_a_board_that_restarts_or_complains_is_zeroed(name, kind, bench: Bench):
    rig = bench.rig(name)
    rig.exchange(300, (0.008, -0.008))
    assert rig.device.state is State.ACTIVE, rig.device.fault_sentence()
    assert rig.truth()["torque"] != [0.0, 0.0]
    rig.fault(kind)
    rig.exchange(30, (0.008, -0.008))
    assert rig.device.state is State.FAULT
    assert rig.device.outcome is WriteOutcome.ZERO_CONFIRMED
    assert rig.truth()["torque"] == [0.0, 0.0]
    assert rig.device.homed is (kind == "alarm")
