"""What every test shares: properties are tried on the same examples everywhere and every time.

A suite that draws anew, or that measures how long an example took, fails now and then on a machine
that is merely busy. ``--hypothesis-profile=search`` draws at random, and more of it.
"""

from __future__ import annotations

import signal

import pytest
from hypothesis import HealthCheck, settings

# A shell starts background jobs with Ctrl-C ignored, and so would everything that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile(
    "repeatable",
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    "search",
    deadline=None,
    max_examples=1000,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("repeatable")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Of a test that is marked ``one_in(n)``, every n-th case is slow and the others exhaustive."""
    seen: dict[str, int] = {}
    for item in items:
        marker = item.get_closest_marker("one_in")
        if marker is not None:
            name = item.nodeid.partition("[")[0]
            number = seen[name] = seen.get(name, -1) + 1
            item.add_marker("exhaustive" if number % marker.args[0] else "slow")
