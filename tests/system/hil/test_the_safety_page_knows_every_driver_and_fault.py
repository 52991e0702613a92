"""The table in docs/safety.md has a cell for every driver and fault.

What stands in each is compared where it is seen (``fault_table.note``).
"""

from __future__ import annotations

import pytest

from tests.support.hil import fault_table
from tests.support.hil.driver_bench import DRIVERS
from tests.system.drivers.test_every_driver_survives_every_fault import FAULTS
from tests.timed.hil.test_supervisor_zeroes_what_is_left import DEATHS


def test_every_driver_and_every_fault_is_in_the_table():
    table = fault_table.read()
    assert list(table) == [*FAULTS, *DEATHS]
    for row in table.values():
        assert list(row) == sorted(DRIVERS)
        assert "–" not in row.values()


def test_what_the_page_does_not_say_fails():
    with pytest.raises(AssertionError, match="does not say of haply"):
        fault_table.note("haply", next(iter(FAULTS)), "nothing at all")
