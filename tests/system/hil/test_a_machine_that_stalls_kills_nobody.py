"""Supervisor and command count own progress: a machine that stands still makes nobody kill anybody.

A loop that stands still while its supervisor goes on is killed within 10 ms and a look; a command
judges after some looks of its own.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from types import SimpleNamespace

import pytest

from cosim.base.system.pulse import RUNNING, SILENT_TICKS, Pulse, Who
from cosim.realtime import supervisor
from cosim.realtime.command import DEAD_LOOP_SECONDS, LEAST_LOOKS, _Stillness


@pytest.fixture
def loop() -> Iterator[int]:
    """A process that does nothing; its beats are the test's."""
    process = os.fork()
    if process == 0:
        signal.pause()
    yield process
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)


def beats_once(pulse: Pulse) -> None:
    """The loop does; whoever has ``pulse`` here is its supervisor otherwise."""
    pulse.who = Who.LOOP
    pulse.beat()
    pulse.who = Who.SUPERVISOR


def looks(monkeypatch, loop: int, each_look: Callable[[int, Pulse], float]) -> tuple[int, str]:
    """Look until something is done about the loop: (after how many looks, why).

    ``each_look`` says how long this process does not run after a look (s).
    """
    pulse, now, count = Pulse(), 100.0, 0
    pulse.state(RUNNING)
    beats_once(pulse)

    def sleep(_: float) -> None:
        nonlocal now, count
        count += 1
        now += each_look(count, pulse)

    monkeypatch.setattr(supervisor, "time", SimpleNamespace(monotonic=lambda: now, sleep=sleep))
    watch = supervisor._Watch(loop, pulse, None, supervisor.STALL_SECONDS)
    monkeypatch.setattr(watch, "_kill", lambda: None)
    monkeypatch.setattr(watch, "_is_over", lambda: count > 200)
    why = watch.to_the_end() or ""
    return count, why


def test_a_loop_that_stands_still_is_killed_after_10_ms(monkeypatch, loop: int):
    count, why = looks(monkeypatch, loop, lambda *_: 0.001)
    assert 10 <= count <= 12
    assert why == "the control loop stood still for 10 ms"


def test_a_machine_that_stands_still_for_300_ms_is_no_reason(monkeypatch, loop: int):
    def stalls(count: int, pulse: Pulse) -> float:
        stands = count % 50 == 0
        if not stands and count % 8 == 0:  # and a loop that is late by some ticks is none either
            beats_once(pulse)
        return 0.3 if stands else 0.001

    assert looks(monkeypatch, loop, stalls)[1] == ""


def test_a_loop_counts_its_own_ticks_without_its_supervisors_beat():
    pulse = Pulse()
    for _ in range(SILENT_TICKS):
        assert not pulse.supervisor_silent()
        pulse.beat()
    assert not pulse.supervisor_silent(), "however long they took"
    pulse.beat()
    assert pulse.supervisor_silent()


def test_a_command_judges_by_looks_of_its_own():
    still = _Stillness()
    still.look(7, 0.0)
    still.look(7, 10.0)
    assert not still.lasts(DEAD_LOOP_SECONDS), "it did not run itself"
    for look in range(LEAST_LOOKS):
        still.look(7, 10.0 + look * 0.02)
    assert still.lasts(DEAD_LOOP_SECONDS)
    still.look(8, 11.0)
    assert not still.lasts(DEAD_LOOP_SECONDS)
