"""The PyPI package ``canopen`` as a master of our emulator: it sets up, reads and drives a node."""

from __future__ import annotations

import time

import canopen
import pytest

from hil.drivers.canopen.emulated_objects import dictionary
from hil.setup.address import parse
from hil.wire.python_can import raw_bus
from tests.support.hil.driver_bench import Bench

CODE = 10.0 / 32767 * 0.5 * 0.0364
PATIENCE = 120.0


@pytest.fixture
def master(bench: Bench, tmp_path):
    """Emulator and node, on the package's own network, with the node's exported EDS."""
    emulator = bench.emulator("canopen", lockstep=False)
    sheet = tmp_path / "node.eds"
    canopen.export_od(dictionary(1), str(sheet))
    network = canopen.Network(raw_bus(parse(emulator.url)))
    network.NOTIFIER_CYCLE = 0.005
    network.connect()
    node = network.add_node(1, str(sheet))
    node.sdo.RESPONSE_TIMEOUT = PATIENCE
    yield emulator, network, node
    network.disconnect()


def until(done):
    end = time.monotonic() + PATIENCE
    while not done():
        assert time.monotonic() < end
        time.sleep(0.005)


def test_the_package_configures_reads_and_drives_the_emulated_node(master):
    emulator, network, node = master
    node.nmt.state = "PRE-OPERATIONAL"
    counts = node.sdo["Measuring units per revolution"].raw
    assert node.sdo["Identity"]["Serial"].raw == 4711
    for channel in (1, 2):
        node.sdo["Analogue output error mode"][channel].raw = 1
        node.sdo["Analogue output error value"][channel].raw = 0
    node.tpdo.read()
    node.rpdo.read()
    transmit, receive = node.tpdo[1], node.rpdo[1]
    transmit.clear()
    for channel in ("Channel 1", "Channel 2"):
        transmit.add_variable("Position values, multi-sensor", channel)
    transmit.trans_type, transmit.enabled = 1, True
    node.tpdo[2].enabled = False
    node.tpdo.save()
    node.rpdo.save()
    assert [entry.name for entry in receive.map] == [
        "Write analogue output.Output 1",
        "Write analogue output.Output 2",
    ]
    node.nmt.state = "OPERATIONAL"

    def sampled():
        network.sync.transmit()
        return transmit.wait_for_reception(0.2) is not None

    until(sampled)
    truth = emulator.control.ask("state")["angle"]
    for channel, angle in zip(transmit, truth, strict=True):
        assert channel.raw / counts * 6.283185307179586 == pytest.approx(angle, abs=1e-3)
    receive[0].raw, receive[1].raw = 1000, -500
    receive.transmit()
    wanted = [1000 * CODE, -500 * CODE]
    until(lambda: emulator.control.ask("state")["torque"] == pytest.approx(wanted, abs=1e-12))
    assert node.sdo["Write analogue output"][2].raw == -500
    # It watches this master from the first heartbeat on, and there is only one.
    node.sdo["Consumer heartbeat time"][1].raw = 99 << 16 | 20
    network.send_message(0x700 + 99, [5])
    until(lambda: node.emcy.log)
    assert (node.emcy.log[0].code, node.emcy.log[0].register) == (0x8130, 0x11)
    until(lambda: emulator.control.ask("state")["torque"] == [0.0, 0.0])
    node.nmt.state = "RESET COMMUNICATION"
    until(lambda: node.sdo["Error register"].raw == 0)


def test_the_package_sees_heartbeats_and_refusals(master):
    _, _, node = master
    node.sdo["Producer heartbeat time"].raw = 5
    node.nmt.wait_for_heartbeat(PATIENCE)
    assert node.nmt.state == "PRE-OPERATIONAL"
    with pytest.raises(canopen.SdoAbortedError):
        node.sdo["TPDO 1 mapping"][1].raw = 0x60200120  # the PDO is valid still
    with pytest.raises(canopen.SdoAbortedError):
        node.sdo["Position value"].raw = 0
