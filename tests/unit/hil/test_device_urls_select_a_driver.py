"""A URL names driver, transport, place and options; a wrong one says what to write instead."""

from __future__ import annotations

import pytest

from cosim.base.errors import InputError
from cosim.scenario import load
from hil.drivers.mock.driver import MockDevice
from hil.setup.address import number, numbers, parse
from hil.setup.registry import find, names


def test_urls_come_apart():
    plain = parse("haply:///dev/ttyACM0")
    assert (plain.driver, plain.transport, plain.serial_url) == ("haply", None, "/dev/ttyACM0")
    bridged = parse("haply+socket://localhost:9999")
    assert bridged.serial_url == "socket://localhost:9999"
    can = parse("odrive+socketcan://can0?nodes=0,1", {"budget": 0.001})
    assert (can.transport, can.place) == ("socketcan", "can0")
    assert numbers(can, "nodes", 2, (3, 4)) == (0, 1)
    assert number(can, "budget", 0.0) == 0.001
    group = parse("odrive+udp_multicast://239.74.163.2:43113", {"nodes": [5, 6]})
    assert group.place == "239.74.163.2:43113"
    assert numbers(group, "nodes", 2, (0, 1)) == (5, 6)


@pytest.mark.parametrize("url", ["/dev/ttyACM0", "haply:/dev/x", "", "mock"])
def test_what_is_no_url_is_refused(url):
    with pytest.raises(InputError, match="driver://place"):
        parse(url)


def test_options_that_do_not_fit_are_refused():
    with pytest.raises(InputError, match="twice"):
        parse("mock://?a=1&a=2")
    with pytest.raises(InputError, match="2 whole numbers"):
        numbers(parse("odrive://x?nodes=1"), "nodes", 2, (0, 1))
    with pytest.raises(InputError, match="number"):
        number(parse("odrive://x?budget=soon"), "budget", 1.0)


def test_drivers_are_found_by_entry_point():
    assert {"mock", "haply", "odrive", "cobs"} <= set(names())
    assert find("mock") is MockDevice
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
