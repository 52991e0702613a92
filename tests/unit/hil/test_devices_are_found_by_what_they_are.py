"""``cohaptic device find``: by USB number and lasting name, and by heartbeats on a bus."""

from __future__ import annotations

import os
import time
from types import SimpleNamespace

import can
import pytest
from serial.tools import list_ports

from hil.setup.address import parse
from hil.setup.can_scan import heard, nodes_on, suggestions
from hil.setup.options import check_options
from hil.setup.registry import find
from hil.setup.search import can_interfaces, candidates
from hil.wire import serial_port
from hil.wire.serial_port import SerialPort


@pytest.fixture
def port(tmp_path, monkeypatch):
    device = tmp_path / "ttyACM3"
    device.write_text("")
    by_id = tmp_path / "by-id"
    by_id.mkdir()
    (by_id / "usb-Maker_Board_5573-if00").symlink_to(device)
    found = SimpleNamespace(vid=0x1234, pid=0x5678, device=str(device), description="a board")
    monkeypatch.setattr(list_ports, "comports", lambda: [found])
    return SimpleNamespace(by_id=by_id, device=device)


def test_a_port_has_its_lasting_name_and_its_number(port):
    shown = candidates(port.by_id)
    urls = {each["url"] for each in shown}
    assert f"haply://{port.by_id}/usb-Maker_Board_5573-if00" in urls
    assert all("(1234:5678)" in each["description"] for each in shown)
    (port.by_id / "usb-Maker_Board_5573-if00").unlink()
    assert f"haply://{port.device}" in {each["url"] for each in candidates(port.by_id)}


def test_a_board_whose_number_is_declared_is_shown_for_its_driver_alone(port, monkeypatch):
    monkeypatch.setattr("hil.drivers.cobs.driver.CobsDriver.usb_ids", ((0x1234, 0x5678),))
    assert [each["url"].partition(":")[0] for each in candidates(port.by_id)] == ["cobs"]


def test_can_interfaces_are_told_by_their_type(tmp_path):
    for name, kind in (("can0", "280"), ("eth0", "1"), ("slcan1", "280")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "type").write_text(f"{kind}\n")
    assert can_interfaces(tmp_path) == ["can0", "slcan1"]


def test_heartbeats_are_told_apart_by_their_length():
    assert heard(0x705, b"\x05") == ("canopen", 5, "operational")
    assert heard(0x705, b"\x85") == ("canopen", 5, "operational"), "the toggle of node guarding"
    assert heard(3 << 5 | 1, bytes(4) + b"\x08" + bytes(3)) == ("odrive", 3, "in closed loop")
    assert heard(3 << 5 | 1, b"\1\0\0\0\1\0\0\0") == ("odrive", 3, "idle, error 0x1")
    assert heard(0x701, bytes(4) + b"\x01" + bytes(3)) == ("odrive", 56, "idle")
    for identifier, data in ((0x700, b"\5"), (0x185, b"\5"), (0x705, b""), (0x80, b"")):
        assert heard(identifier, data) is None


def test_what_says_no_state_is_no_heartbeat():
    assert heard(0x705, b"\x33") is None
    assert heard(3 << 5 | 1, bytes(4) + b"\x63" + bytes(3)) is None


def test_a_canopen_nodes_other_frames_are_no_axis():
    bus = {"interface": "virtual", "channel": "scan-402"}
    with can.Bus(**bus) as host, can.Bus(**bus) as node:
        for identifier, data in ((0x701, [5]), (0x181, [0, 0, 0, 0, 8, 0, 0, 0])):
            node.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))
        assert set(nodes_on(host, 0.1)) == {("canopen", 1)}


def test_two_canopen_nodes_may_be_drives():
    found = {("canopen", 4): "operational", ("canopen", 7): "stopped", ("odrive", 3): "idle"}
    urls = [each["url"] for each in suggestions("can0", found)]
    assert "canopen+socketcan://can0?nodes=4" in urls
    assert "cia402+socketcan://can0?nodes=4,7" in urls
    assert not any("odrive" in url for url in urls)


@pytest.mark.parametrize("axes", [(3,), (3, 5), (3, 5, 9)])
def test_every_url_that_a_scan_shows_is_one_that_its_driver_takes(axes):
    found = {("canopen", 4): "operational", ("canopen", 7): "stopped"}
    found |= {("odrive", axis): "idle" for axis in axes}
    shown = suggestions("can0", found)
    for each in shown:
        if each["url"] != "can0":
            address = parse(each["url"])
            check_options(find(address.driver).options, address)
    said = [each["description"] for each in shown if each["url"] == "can0"]
    assert [f"ODrive axis {axis} is idle" in text for axis, text in zip(axes, said, strict=True)]
    assert all(("alone" in text) is (len(axes) == 1) for text in said)
    assert ("odrive+socketcan://can0?nodes=3,5" in {e["url"] for e in shown}) is (len(axes) > 1)


def test_a_bus_is_only_listened_to():
    bus = {"interface": "virtual", "channel": "scan"}
    with can.Bus(**bus) as host, can.Bus(**bus) as node:
        node.send(can.Message(arbitration_id=0x702, data=[127], is_extended_id=False))
        node.send(can.Message(arbitration_id=0x21, data=bytes(8), is_extended_id=False))
        assert set(nodes_on(host, 0.1)) == {("canopen", 2), ("odrive", 1)}
        assert node.recv(0) is None, "nothing was sent"


def test_a_board_that_resets_is_waited_for_and_its_greeting_dropped(monkeypatch):
    master, slave = os.openpty()
    os.set_blocking(master, False)

    def start(seconds: float) -> None:
        assert seconds == 0.2
        os.write(master, b"Board 1.0 is starting\r\n")
        time.sleep(0.05)

    monkeypatch.setattr(serial_port, "wait_for_board", start)
    made = SerialPort(parse(f"cobs://{os.ttyname(slave)}?wait=200 ms"))
    assert made.read() == b""
    made.close()
    os.close(master)
    os.close(slave)
