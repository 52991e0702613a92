"""A URL names driver, transport, place and options; a wrong one says what to write instead."""

from __future__ import annotations

import pytest

from cosim.base.errors import InputError
from cosim.scenario import load
from hil.drivers.mock.driver import MockDriver
from hil.drivers.odrive.settings import OdriveOptions
from hil.setup.address import parse
from hil.setup.options import check_options, read_options
from hil.setup.registry import find, names
from hil.wire.can_options import can_options


def test_urls_come_apart():
    plain = parse("haply:///dev/ttyACM0")
    assert (plain.driver, plain.transport, plain.serial_url) == ("haply", None, "/dev/ttyACM0")
    bridged = parse("haply+socket://localhost:9999")
    assert bridged.serial_url == "socket://localhost:9999"
    can = parse("odrive+socketcan://can0?nodes=0,1", {"budget": 0.001})
    assert (can.transport, can.place) == ("socketcan", "can0")
    assert read_options(OdriveOptions, can).nodes == (0, 1)
    assert read_options(OdriveOptions, can).budget == 0.001
    group = parse("odrive+udp_multicast://239.74.163.2:43113", {"nodes": [5, 6]})
    assert group.place == "239.74.163.2:43113"
    assert read_options(OdriveOptions, group).nodes == (5, 6)


@pytest.mark.parametrize("url", ["/dev/ttyACM0", "haply:/dev/x", "", "mock"])
def test_what_is_no_url_is_refused(url):
    with pytest.raises(InputError, match="driver://place"):
        parse(url)


def test_options_that_do_not_fit_are_refused():
    with pytest.raises(InputError, match="twice"):
        parse("mock://?a=1&a=2")


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("odrive://x?nodes=1", "two different node numbers"),
        ("odrive://x?nodes=1,1", "twice"),
        ("odrive://x?budget=soon", "time, such as"),
        ("odrive://x?node=1,2", "Did you mean nodes"),
        ("haply:///dev/ttyACM0?baud=abc", "baud rate"),
        ("haply:///dev/ttyACM0?lockstep=yes", "'0' or '1'"),
        ("haply:///dev/ttyACM0?nodes=1,2", "unknown key 'nodes'"),
        ("mock://?nodes=1", "unknown key 'nodes'"),
        ("quanser://q8_usb/0?encoders=0,0", "twice"),
        ("moteus:///dev/x?ids=0,1", "1 to 127"),
        ("canopen+socketcan://can0?nodes=1,2,3,4", "one node with both"),
    ],
)
def test_an_option_that_a_driver_does_not_have_is_refused_with_the_url(url, says):
    address = parse(url)
    with pytest.raises(InputError, match=says) as caught:
        check_options(find(address.driver).options, address)
    assert url in str(caught.value)


def test_an_option_of_another_kind_of_bus_is_refused():
    address = parse("odrive+socketcan://can0?sleep_after_open=1")
    with pytest.raises(InputError, match="slcan"):
        can_options(address)


def test_drivers_are_found_by_entry_point():
    assert {"mock", "haply", "odrive", "cobs"} <= set(names())
    assert find("mock") is MockDriver
    with pytest.raises(InputError, match="did you mean 'haply'"):
        find("haptly")


def test_a_scenario_takes_the_urls_that_emulators_print():
    for url in (
        "canopen+udp_multicast://239.74.163.2:43113?nodes=1",
        "odrive+slcan:///dev/pts/3",
        "haply+rfc2217://host:1",
    ):
        loaded = load("two_users_box", (), [f"components.finger_a1.device='{url}'"])
        assert loaded.components["finger_a1"].source == url
