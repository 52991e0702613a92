"""Every CANopen node is set up before the loop, all of it is read back, and no thread is left."""

from __future__ import annotations

import threading

import pytest

from cosim.base.errors import InputError
from hil.device.contract import State
from hil.device.errors import DeviceError
from hil.drivers.canopen.settings import layout_of
from tests.support.hil.canopen_bench import REST, Wire, run

LAYOUTS = {"1": (1,), "1,2": (1, 2), "1,2,3": (1, 2, 3)}


@pytest.fixture
def wire(request):
    made = Wire(*getattr(request, "param", ((1,),)))
    yield made
    made.close()


def every(*devices):
    return pytest.mark.parametrize("wire", [devices], indirect=True)


@pytest.mark.parametrize(
    ("wire", "nodes"), [([each], text) for text, each in LAYOUTS.items()], indirect=["wire"]
)
def test_each_layout_has_its_mapping_and_its_zero_on_error(wire, nodes):
    threads = threading.active_count()
    device = wire.device(nodes)
    device.configure()
    assert threading.active_count() == threads, "the package's thread has to be gone"
    chosen = layout_of(device.address, device.file)
    for number in chosen.nodes:
        value = wire.node(number).value
        assert value(0x1017, 0) == 5
        assert value(0x1801, 1) >> 31 == 1, "a PDO that nobody asked for is off"
    for encoder in chosen.encoders:
        value = wire.node(encoder.node).value
        assert (value(0x1800, 1), value(0x1800, 2)) == (0x180 + encoder.node, 1)
    for output in chosen.outputs:
        value = wire.node(output.node).value
        channel = output.value.subindex
        assert (value(0x1400, 1), value(0x1400, 2)) == (0x200 + output.node, 255)
        assert (value(0x6443, channel), value(0x6444, channel)) == (1, 0)
        assert value(0x1016, 1) == 0, "nobody is watched before activation"
    first = wire.node(chosen.encoders[0].node).value
    if nodes == "1":
        assert [first(0x1A00, n) for n in (0, 1, 2)] == [2, 0x60200120, 0x60200220]
        assert [first(0x1600, n) for n in (0, 1, 2)] == [2, 0x64110110, 0x64110210]
    else:
        assert [first(0x1A00, n) for n in (0, 1)] == [1, 0x60040020]
    assert device.watchdog.verified
    assert device.watchdog.timeout == 0.02
    device.home()
    measured = run(device, 3)
    assert measured.joint_angle == pytest.approx(REST, abs=device.file.quantum)
    assert measured.count[0] == pytest.approx(REST[0] / device.file.joints[0].quantum, abs=1)


KEPT = {
    0x6443: "6443h:1",
    0x6444: "6444h:1",
    0x1016: "1016h:1",
    0x1017: "1017h:0",
    0x1029: "1029h:1",
    0x1400: "1400h:1",
    0x1600: "1600h:0",
    0x1800: "1800h:1",
    0x1801: "1801h:1",
    0x1A00: "1A00h:0",
}


@pytest.mark.parametrize("index", KEPT)
def test_a_node_that_does_not_keep_a_setting_is_refused(wire, index):
    local = wire.node(1).local
    whole = local.set_data
    if index == 0x1029:
        whole(0x1029, 1, b"\1")

    def forgetful(at, subindex, data, check_writable=False):
        if at != index:
            whole(at, subindex, data, check_writable)

    local.set_data, local.forget = forgetful, lambda: None
    device = wire.device()
    with pytest.raises(DeviceError, match=f"did not keep {KEPT[index]}"):
        device.configure()
    assert device.state is State.UNCONFIGURED


@every((5,))
def test_a_node_that_is_not_there_is_named(wire):
    device = wire.device("5,1", settings={"timeout": 0.05})
    with pytest.raises(DeviceError, match="node 1 does not answer on virtual"):
        device.configure()


def test_an_encoder_of_another_resolution_is_refused(wire):
    joints = [{"counts_per_turn": 8192}, {"counts_per_turn": 8192}]
    with pytest.raises(DeviceError, match=r"counts 20000 a turn \(6001h:0\).* says 8192"):
        wire.device(joints=joints).configure()


def test_a_node_that_reports_an_error_is_refused(wire):
    node = wire.node(1)
    boot = node.boot
    node.boot = lambda: (boot(), node.local.set_data(0x1001, 0, b"\x81"))
    with pytest.raises(DeviceError, match=r"node 1 reports an error.*0x81"):
        wire.device().configure()


def test_another_serial_number_is_refused(wire):
    with wire.device(serial="4711") as device:
        device.configure()
    with pytest.raises(DeviceError, match=r"4711.*4712"):
        wire.device(serial="4712").configure()


@pytest.mark.parametrize(
    ("document", "sentence"),
    [
        ({"settings": {"nodes": [1, 1]}}, "has one twice"),
        ({"settings": {"nodes": [128]}}, "numbers of 1 to 127"),
        ({"settings": {"nodes": [1, 2, 3, 4]}}, r"one node with both joints.*not \[1, 2, 3, 4\]"),
        ({"settings": {"watchdgo": 20}}, "Did you mean watchdog"),
        ({"settings": {"watchdog": 0.02}}, "at least 1 ms"),
        ({"settings": {"timeout": "soon"}}, "time, such as 5"),
        ({"settings": {"preset": 0}}, "true or false"),
        ({"settings": {"encoders": [{"node": 1}]}}, "at least 2 items"),
        ({"settings": {"encoders": [{"node": 1}, {"node": 1}]}}, "same object"),
        ({"settings": {"outputs": [{"node": 1, "chanel": 1}, {}]}}, "Did you mean channel"),
        ({"joints": [{"drive": {"bias": 1.0}}, {}]}, "trim the amplifier"),
    ],
)
def test_a_device_file_that_cannot_be_is_a_sentence(wire, document, sentence):
    with pytest.raises(InputError, match=sentence):
        wire.device("1", **document).configure()


@every((7,))
def test_objects_of_a_second_logical_device_can_be_spelled_out(wire):
    settings = {
        "encoders": [
            {"node": 7, "object": 0x6004},
            {"node": 7, "object": 0x6804},
        ],
        "outputs": [
            {"node": 7, "object": 0x6411, "channel": 1},
            {"node": 7, "object": 0x6C11, "channel": 2},
        ],
    }
    device = wire.device("7", settings=settings)
    chosen = layout_of(device.address, device.file)
    assert str(chosen.encoders[1].units_per_turn) == "6801h:0"
    assert str(chosen.encoders[1].range) == "6802h:0"
    assert str(chosen.encoders[1].preset) == "6803h:0"
    assert str(chosen.outputs[1].error_mode) == "6C43h:2"
    assert str(chosen.outputs[1].error_value) == "6C44h:2"
    assert chosen.frames == (8, 4)


@every((1,), (2,))
def test_two_devices_on_one_bus_share_one_sync(wire):
    devices = [wire.device("1"), wire.device("2")]
    for device in devices:
        device.configure()
        device.home()
    run(devices[1], 1)
    wire.seen.clear()
    for tick in range(20):
        turned = REST[0] + 0.005 * tick
        for puppet in wire.puppets:
            puppet.place = (turned, REST[1])
        for device in devices:
            measured = device.read(tick)
            assert measured.sample_age == 0
            assert measured.joint_angle[0] == pytest.approx(turned, abs=1e-3), "not a tick older"
        for device in devices:
            device.write(tick, (0.0, 0.0))
    devices[0].read(20)
    assert sum(frame.identifier == 0x080 for frame in wire.seen) == 21
    with pytest.raises(InputError, match=r"node 1 on .* belongs to another device"):
        wire.device("1").configure()


@every((1,), (2,), (3,), (4,))
def test_a_fourth_pantograph_on_one_bus_is_refused_with_the_number(wire):
    for number in (1, 2, 3):
        wire.device(str(number)).configure()
    with pytest.raises(InputError, match=r"82\.6%.*second bus"):
        wire.device("4").configure()
