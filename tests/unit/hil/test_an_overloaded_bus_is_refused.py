"""The load of a CAN bus is known before it is used, and an impossible one names its number."""

from __future__ import annotations

import pytest

from cosim.base.errors import InputError
from hil.drivers.odrive.driver import FRAMES
from hil.wire.can_load import bus_load, frame_bits, refuse_overload

RATE = 1024


def test_bits_of_a_classic_frame():
    assert [frame_bits(size) for size in (0, 4, 8)] == [47, 79, 111]
    assert frame_bits(8, stuffed=True) == 135


def test_published_loads_of_two_axis_nodes():
    sync, node = 0, (8, 4)
    for nodes, percent in ((1, 24), (2, 44), (4, 83)):
        assert 100 * bus_load([sync, *node * nodes], RATE).plain == pytest.approx(percent, abs=0.5)
    assert 100 * bus_load([sync, *node * 4], RATE).worst == pytest.approx(99.8, abs=0.05)
    for pairs, percent in ((1, 39), (2, 78)):
        assert 100 * bus_load(FRAMES * pairs, RATE).plain == pytest.approx(percent, abs=0.5)


def test_four_pantographs_on_one_classic_bus_are_refused_with_the_number():
    with pytest.raises(InputError, match=r"82\.6%.*second bus"):
        refuse_overload("can0", [0, *(8, 4) * 4], RATE, 1e6)
    assert refuse_overload("can0", FRAMES * 2, RATE, 1e6).plain < 0.8
