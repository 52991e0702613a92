"""What one device has, no other gets: not in this process, not in another, not by another name."""

from __future__ import annotations

import os
import signal

import pytest

from cosim.base.errors import CohapticError
from hil.device.errors import DeviceError
from hil.wire.ownership import OwnedNodes
from tests.support.hil.driver_bench import DRIVERS, Bench


@pytest.mark.parametrize("name", DRIVERS)
def test_a_second_device_on_the_same_place_is_refused(name: str, bench: Bench):
    emulator = bench.emulator(name)
    first, second = (bench.device(name, emulator) for _ in range(2))
    first.configure()
    with pytest.raises(CohapticError, match=r"(in use by|belongs to) another device"):
        second.configure()
    first.read(0)
    first.write(0, (0.0, 0.0))
    assert first.fault is None, "and it noticed nothing"
    first.close()


@pytest.mark.parametrize("name", ["haply", "odrive"])
def test_another_process_is_refused_by_name_until_the_owner_has_died(name: str, bench: Bench):
    emulator = bench.emulator(name)
    ready, tell = os.pipe()
    owner = os.fork()
    if owner == 0:
        bench.device(name, emulator).configure()
        os.write(tell, b"r")
        signal.pause()
    assert os.read(ready, 1) == b"r"
    try:
        with pytest.raises(DeviceError, match=rf"in use by process {owner}"):
            bench.device(name, emulator).configure()
    finally:
        os.kill(owner, signal.SIGKILL)
        os.waitpid(owner, 0)
    late = bench.device(name, emulator)
    late.configure()
    late.close()


def test_other_nodes_of_the_same_bus_are_free():
    first, second = OwnedNodes("can0", (0, 1)), OwnedNodes("can0", (2, 3))
    with pytest.raises(DeviceError, match="node 1 on can0"):
        OwnedNodes("can0", (4, 1))
    OwnedNodes("can0", (4,)).close()
    for owned in (first, second):
        owned.close()
