"""Emulators in processes of their own, in lock-step with the test."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator

import pytest

from hil.setup.session import Session, begin
from tests.support.hil.driver_bench import Bench, Rig

multiprocessing.set_forkserver_preload(["hil.emulation.launch", "fmpy.fmi3", "can"])


@pytest.fixture(autouse=True)
def dry_session() -> None:
    """What an earlier test allowed its devices does not hold for the next one's."""
    begin(Session())


@pytest.fixture
def bench() -> Iterator[Bench]:
    """Makes devices on emulators and closes both."""
    made = Bench()
    yield made
    made.close()


@pytest.fixture
def rig(request: pytest.FixtureRequest, bench: Bench) -> Rig:
    """One active device on its emulator; the driver's name is the indirect parameter."""
    return bench.rig(request.param)
