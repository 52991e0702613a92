"""Two devices of a scenario on one port, one node or one bus with two bit rates are refused."""

from __future__ import annotations

import os

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from hil.device.contract import BusUse
from hil.device.driver import Driver
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from hil.wire import can_bus
from hil.wire.can_bus import open_bus

FINGERS = ("finger_a1", "finger_a2")


def check(folder, first: str, second: str) -> str:
    lines = ["components:"]
    for finger, url in zip(FINGERS, (first, second), strict=True):
        lines.append(f'  {finger}: {{device: "{url}"}}')
        lines.append(f"  {finger.replace('finger', 'operator')}: ~")
    sizes = [
        f"finger_{number}.device: {'haply' if url.startswith('haply') else 'quanser'}"
        for number, url in enumerate((first, second), 1)
    ]
    lines.append(f"  vr_a: {{parameters: {{{', '.join(sizes)}}}}}")
    path = folder / "bench.yaml"
    path.write_text("\n".join(lines) + "\n")
    arguments = ["check", "two_users_box", "--with", str(path)]
    return CliRunner().invoke(cli, arguments, catch_exceptions=False, standalone_mode=False).stdout


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        ("haply:///dev/ttyACM0", "haply:///dev/ttyACM0", "/dev/ttyACM0"),
        ("haply:///dev/ttyACM0", "haply:///dev/../dev/ttyACM0?ports=3,4", "/dev/ttyACM0"),
        ("haply:///dev/ttyACM0", "cobs:///dev/ttyACM0", "/dev/ttyACM0"),
        (
            "odrive+socketcan://can0?nodes=0,1",
            "odrive+socketcan://can0?nodes=1,2",
            "node 1 on socketcan://can0",
        ),
        (
            "canopen+socketcan://can0?nodes=7",
            "canopen+socketcan://can0?nodes=7",
            "node 7 on socketcan://can0",
        ),
        (
            "odrive+socketcan://can0?nodes=0,1",
            "odrive+socketcan://can0?nodes=2,3&bitrate=500000",
            "bitrate",
        ),
        (
            "odrive+socketcan://can0?nodes=0,1&budget=0.0005",
            "odrive+socketcan://can0?nodes=2,3",
            "budget",
        ),
    ],
)
def test_what_two_devices_would_share_is_named_at_its_line(tmp_path, first, second, words):
    with pytest.raises(InputError) as refused:
        check(tmp_path, first, second)
    assert words in str(refused.value)
    assert refused.value.location.file.endswith("bench.yaml")


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("odrive+socketcan://can0?nodes=0,0", "two different node numbers"),
        ("canopen+socketcan://can0?nodes=7,7", "different numbers of 1 to 127"),
    ],
)
def test_two_joints_of_one_device_are_two_nodes(tmp_path, url, words):
    with pytest.raises(InputError, match=words):
        check(tmp_path, url, "mock://")


def test_a_port_by_another_name_is_the_same_port(tmp_path):
    by_id = tmp_path / "usb-Haply"
    os.symlink("/dev/ttyACM0", by_id)  # noqa: PTH211
    with pytest.raises(InputError, match="usb-Haply, where finger_a1 is already"):
        check(tmp_path, "haply:///dev/ttyACM0", f"haply://{by_id}")


def test_mocks_and_different_nodes_share_nothing(tmp_path):
    assert check(tmp_path, "mock://", "mock://")
    assert check(tmp_path, "odrive+socketcan://can0?nodes=0,1", "odrive+socketcan://can0?nodes=2,3")


def test_an_open_bus_does_not_take_another_bit_rate(monkeypatch):
    class Port:
        tells_sent = False

        def close(self) -> None: ...

    monkeypatch.setattr(can_bus, "_port", lambda _: Port())
    monkeypatch.setattr(can_bus, "_OPEN", {})
    open_bus(parse("odrive+socketcan://can0"))
    open_bus(parse("odrive+socketcan://can0?nodes=2,3"))
    with pytest.raises(InputError, match="bitrate"):
        open_bus(parse("odrive+socketcan://can0?nodes=4,5&bitrate=500000"))


def test_what_a_driver_claims_on_a_bus_is_what_it_uses():
    from hil.drivers.canopen.driver import CanopenDriver
    from hil.drivers.odrive.driver import OdriveDriver

    def nodes(kind: type[Driver], url: str) -> tuple[int, ...]:
        use = kind.bus_use(parse(url), parse_file({"driver": kind.driver}))
        assert isinstance(use, BusUse)
        return use.nodes

    assert nodes(OdriveDriver, "odrive+socketcan://can0?nodes=4,9") == (4, 9)
    assert nodes(CanopenDriver, "canopen+socketcan://can0?nodes=4,9,12") == (4, 9, 12)
