"""However the control loop dies, the supervisor brings the device to zero and says so."""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress

import pytest

from cosim.base.system.pulse import RUNNING, Pulse
from cosim.realtime.supervisor import supervise
from hil.device.contract import State
from hil.device.errors import DeviceFault
from tests.support.hil import fault_table
from tests.support.hil.driver_bench import DRIVERS, SETUPS, Bench

SERIAL = [name for name in DRIVERS if SETUPS[name].get("serial", False)]
TICKS = 60
KILLED, STOPPED, ORPHANED = DEATHS = (
    "loop killed (SIGKILL) while it writes",
    "loop stopped (SIGSTOP)",
    "supervisor killed (SIGKILL)",
)
"""What the safety page says of them."""
OFFSETS: dict[str, set[int]] = {}
"""Byte offsets of a frame at which a driver's loop was killed and its device zeroed."""


def exchanging(rig, pulse, after):
    """A loop that exchanges for some ticks and then does ``after``."""

    def loop() -> int:
        rig.device.activate()
        pulse.state(RUNNING)
        for _ in range(TICKS):
            pulse.beat()
            rig.exchange(1, (0.01, -0.01))
        after()
        return 0

    return loop


def supervised(rig, pulse, after, *, stall=20.0):
    ending = supervise(
        [(0, rig.device)], exchanging(rig, pulse, after), pulse, stall=stall, real_time=False
    )
    return ending, rig.truth()


def prepared(bench: Bench, name: str):
    pulse = Pulse()
    rig = bench.rig(name, activate=False, pulse=pulse)
    return rig, pulse


def frame_length(name: str) -> int:
    return SETUPS[name]["frame"]


@pytest.mark.parametrize(
    ("name", "offset"), [(name, n) for name in SERIAL for n in range(frame_length(name) + 1)]
)
def test_a_loop_killed_at_any_byte_of_a_frame(name: str, offset: int, bench: Bench):
    rig, pulse = prepared(bench, name)
    port = rig.device.driver._port

    def die():
        assert rig.emulator.control is not None
        whole = port._write

        def part(data):
            if offset:
                whole(data[:offset])
            os.kill(os.getpid(), signal.SIGKILL)

        port._write = part
        rig.exchange(1, (0.02, -0.02))

    ending, truth = supervised(rig, pulse, die)
    assert ending.status == -signal.SIGKILL
    assert pulse.is_cold(0)
    assert truth["torque"] == [0.0, 0.0]
    assert "SIGKILL" in ending.reason
    done = OFFSETS.setdefault(name, set())
    done.add(offset)
    if len(done) == frame_length(name) + 1:
        fault_table.note(
            name, KILLED, f"the supervisor confirms zero, at each of {len(done)} byte offsets"
        )


@pytest.mark.parametrize("name", DRIVERS)
@pytest.mark.parametrize("how", ["stopped", "busy", "returns", "raises", "killed between frames"])
def test_a_loop_that_ends_or_stands_still(name: str, how: str, bench: Bench):
    rig, pulse = prepared(bench, name)

    def fail():
        raise RuntimeError("a bug")

    def spin():
        while True:
            pass

    after = {
        "stopped": lambda: os.kill(os.getpid(), signal.SIGSTOP),
        "busy": spin,
        "returns": lambda: None,
        "raises": fail,
        "killed between frames": lambda: os.kill(os.getpid(), signal.SIGKILL),
    }[how]
    stall = 0.5 if how in {"stopped", "busy"} else 20.0
    ending, truth = supervised(rig, pulse, after, stall=stall)
    assert pulse.is_cold(0)
    assert truth["torque"] == [0.0, 0.0]
    if how in {"stopped", "busy"}:
        assert "stood still" in ending.reason
    assert (ending.status == 0) is (how == "returns")
    if how == "stopped":
        fault_table.note(name, STOPPED, "the supervisor kills it and confirms zero")
    if how == "killed between frames" and name not in SERIAL:
        fault_table.note(name, KILLED, "the supervisor confirms zero, between two whole frames")


@pytest.mark.parametrize("name", DRIVERS)
def test_a_loop_whose_supervisor_died_zeroes_and_faults(name: str, bench: Bench):
    rig, pulse = prepared(bench, name)
    said, tell = os.pipe()
    supervisor = os.fork()
    if supervisor == 0:
        pulse.supervised_here()
        loop = os.fork()
        if loop == 0:
            with suppress(BaseException):
                rig.device.activate()
                rig.exchange(TICKS, (0.01, -0.01))
                os.write(tell, b"r")
                while pulse.supervisor_alive():
                    time.sleep(0.001)
                rig.exchange(1, (0.01, -0.01))
                fault = rig.device.state is State.FAULT
                rig.exchange(30, (0.01, -0.01))
                try:
                    rig.device.raise_fault()
                except DeviceFault as error:
                    ok = fault and "supervisor" in str(error) and "zero torque" in str(error)
                    os.write(tell, b"y" if ok else b"n")
            os._exit(0)
        time.sleep(60)
        os._exit(0)
    assert os.read(said, 1) == b"r"
    os.kill(supervisor, signal.SIGKILL)
    os.waitpid(supervisor, 0)
    assert os.read(said, 1) == b"y"
    assert rig.truth()["torque"] == [0.0, 0.0]
    fault_table.note(name, ORPHANED, "fault (supervisor) at the next write; zero confirmed")
    rig.device.release()  # what the loop's process exchanged is not known here
    os.close(said)
    os.close(tell)


def test_a_device_that_cannot_be_zeroed_is_said_to_be_unknown(bench: Bench):
    rig, pulse = prepared(bench, "haply")
    rig.fault("unplug", start=TICKS - 10)
    ending, _ = supervised(rig, pulse, lambda: os.kill(os.getpid(), signal.SIGKILL))
    assert ending.status == -signal.SIGKILL
    assert not pulse.is_cold(0)
