"""The table in docs/safety.md is what the tests before this one saw, for every driver and fault."""

from __future__ import annotations

import pytest

from tests.support.hil import fault_table
from tests.support.hil.driver_bench import DRIVERS
from tests.system.drivers.test_every_driver_survives_every_fault import FAULTS
from tests.timed.hil.test_supervisor_zeroes_what_is_left import DEATHS


def test_the_safety_page_says_what_was_seen():
    rows = [*FAULTS, *DEATHS]
    if any((driver, row) not in fault_table.SEEN for driver in DRIVERS for row in rows):
        pytest.skip("only part of the suite ran")
    fault_table.check(fault_table.SEEN)
