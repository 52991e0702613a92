"""Console and live view read shared memory in other processes: nothing blocks, nothing is torn."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from math import hypot
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.cli.live import choose
from cosim.cli.support.plot import HEIGHT, plot
from cosim.realtime.live import Feed, StatusWriter
from cosim.realtime.ring import Ring
from cosim.realtime.watcher import Watcher, find_feed
from hil.device.component import DeviceComponent
from hil.device.contract import State
from hil.device.errors import Cause
from hil.drivers.mock.driver import MockDriver
from tests.support.hil.hil_bench import QUANSER, REST_ANGLE, Puppet, mock, rested, run
from tests.support.terminal import at_a_terminal

LATENESS = SimpleNamespace(misses=3, slipped=4, worst=1_500_000)
COMPONENT = DeviceComponent(MockDriver, "mock://", {})
COLUMNS = [
    SimpleNamespace(name="vr.box.x", unit="m", is_float=True),
    SimpleNamespace(name="vr.contacts", unit=None, is_float=False),
]


@pytest.fixture
def feed():
    rings = [Ring.create(2, capacity=64)]
    made = Feed(f"bench-{os.getpid()}", 1024.0, {"finger": COMPONENT}, rings)
    made.publish([SimpleNamespace(name="control", period=1, columns=COLUMNS)], Path("/tmp/run-7"))
    made.rings = rings
    yield made
    made.remove()
    rings[0].remove()


def active():
    device = rested(mock(Puppet()))
    device.activate()
    run(device, 2000, (0.004, -0.004))
    return device


def test_the_newest_row_says_how_loop_and_device_stand(feed):
    device = active()
    writer = StatusWriter(feed.status, [device], LATENESS)
    with Watcher(find_feed(feed_name())) as watcher:
        assert watcher.status() is None
        writer.write(2000)
        seen = watcher.status()
        assert (seen.tick, seen.misses, seen.slipped, seen.worst) == (2000, 3, 4, 1.5e-3)
        (finger,) = seen.devices
        assert finger.state == State.ACTIVE
        assert finger.torque == device.sent
        assert finger.joint_angle == pytest.approx(REST_ANGLE, abs=1e-3)
        assert "finger active" in seen.line()
        device.read(2000)
        device.write(2000, (float("nan"), 0.0))
        writer.write(2001)
        (finger,) = watcher.status().devices
        assert finger.state == State.FAULT
        assert finger.cause == Cause.COMMAND
        assert "FAULT: command" in watcher.status().line()


def feed_name() -> str:
    return f"bench-{os.getpid()}"


@settings(deadline=None, max_examples=60)
@given(st.floats(-0.02, 0.08), st.floats(0.13, 0.22), st.floats(-1, 1), st.floats(-1, 1))
def test_the_force_at_the_tip_does_the_work_of_the_torques(x, y, first, second):
    """Virtual work: torque . d(angle) = force . d(tip), for any small motion."""
    angle = QUANSER.angles((x, y))
    force = QUANSER.tip_force(angle, (first, second))
    for motion in ((1e-5, 0.0), (0.0, 1e-5)):
        other = QUANSER.angles((x + motion[0], y + motion[1]))
        turned = [b - a for a, b in zip(angle, other, strict=True)]
        work = first * turned[0] + second * turned[1]
        done = force[0] * motion[0] + force[1] * motion[1]
        assert work == pytest.approx(done, abs=2e-3 * 1e-5 * (1 + hypot(*force)))


WATCHING = """
import json, sys, time
from pathlib import Path
from cosim.realtime.watcher import Watcher
with Watcher(Path(sys.argv[1])) as watcher:
    watcher.watch(["vr.box.x", "vr.contacts"])
    print("watching", flush=True)
    rows, torn, last = 0, 0, -1.0
    going_on = True
    while going_on:
        going_on = watcher.running
        found = watcher.rows()
        x, contacts = found["vr.box.x"], found["vr.contacts"]
        torn += int((x != contacts).sum()) + int((x[1:] <= x[:-1]).sum())
        torn += int(len(x) > 0 and x[0] <= last)
        rows, last = rows + len(x), x[-1] if len(x) else last
        time.sleep(0.0005)
    print(json.dumps({"rows": rows, "lost": watcher.lost, "torn": torn, "last": last}))
"""


def second_process():
    path = find_feed(feed_name())
    return subprocess.Popen(
        [sys.executable, "-c", WATCHING, str(path)], stdout=subprocess.PIPE, text=True
    )


def put(ring: Ring, first: int, end: int) -> None:
    row = np.zeros(2, np.int64)
    cells = memoryview(row).cast("B").cast("q")
    for number in range(first, end):
        row.view(np.float64)[0], row[1] = number, number
        ring.put(cells)


def stop(watching) -> None:
    os.kill(watching.pid, signal.SIGSTOP)
    os.waitpid(watching.pid, os.WUNTRACED)


def test_a_second_process_gets_whole_rows_and_counts_what_it_lost(feed):
    """The ring holds 64 rows; who stands still for a thousand has lost what is gone."""
    ring = feed.rings[0]
    with second_process() as watching:
        assert watching.stdout.readline() == "watching\n"
        for first in range(0, 10_000, 50):
            put(ring, first, first + 50)
            time.sleep(0.0002)
        stop(watching)
        put(ring, 10_000, 11_000)
        os.kill(watching.pid, signal.SIGCONT)
        put(ring, 11_000, 20_000)
        find_feed(feed_name()).unlink()  # what the end of a run does first
        seen = json.loads(watching.stdout.readline())
    assert seen["torn"] == 0
    assert seen["rows"] + seen["lost"] == 20_000
    assert seen["last"] == 19_999
    assert seen["lost"] >= 1000 - ring.capacity


def test_a_reader_cannot_write(feed):
    with Watcher(find_feed(feed_name())) as watcher:
        watcher.watch(["vr.box.x"])
        with pytest.raises(ValueError, match="read-only"):
            watcher._status.values[0] = 1.0
        with pytest.raises(TypeError):
            put(watcher._readers[0].reader._ring, 0, 1)


def test_a_stopped_reader_never_holds_up_the_writer(feed):
    """Even one that is stopped in the middle: the writer asks nobody."""
    with second_process() as watching:
        assert watching.stdout.readline() == "watching\n"
        stop(watching)
        put(feed.rings[0], 0, 10_000)
        assert feed.rings[0].written == 10_000
        watching.kill()


def test_a_run_is_found_by_name_process_and_folder(feed):
    path = find_feed(feed_name())
    assert find_feed(str(os.getpid())) == find_feed("/tmp/run-7") == path
    with pytest.raises(InputError, match="'cohaptic run --realtime'"):
        find_feed("no-such-run")


def test_the_command_shows_one_status_for_programs(feed):
    StatusWriter(feed.status, [active()], LATENESS).write(5)
    done = CliRunner().invoke(cli, ["live", feed_name(), "--json"], catch_exceptions=False)
    shown = json.loads(done.stdout)
    assert shown["status"]["tick"] == 5
    assert shown["status"]["devices"][0]["state"] == "active"
    with pytest.raises(InputError, match="records nothing like"):
        choose(["a.x"], ["b.*"])
    assert choose(["a.x", "a.y"], ["*.y"]) == ["a.y"]


@settings(deadline=None, max_examples=60)
@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=400))
def test_a_plot_shows_every_peak(values):
    title, *lines = plot("a", "m", values)
    assert len(lines) == HEIGHT
    assert len({len(line) for line in lines}) == 1
    assert f"{values[-1]:.4g} m" in title
    if max(values) > min(values):
        assert "█" in lines[0], "the largest value reaches the top line"
    assert plot("a", "m", []) == ["a: nothing yet"]


@given(
    name=st.text("ab.[1]_", min_size=1, max_size=90),
    unit=st.sampled_from(["", "m", "N.m.s/rad"]),
    values=st.lists(st.floats(-1e300, 1e300), min_size=1, max_size=90),
)
def test_no_line_of_a_plot_is_longer_than_the_terminal_is_wide(name, unit, values):
    assert max(map(len, plot(name, unit, values, 40))) <= 40


def test_a_terminal_of_40_columns_shows_status_and_signals(feed, tmp_path):
    StatusWriter(feed.status, [active()], LATENESS).write(5)
    words = ["live", feed_name(), "--show", "vr.*", "--seconds", "0.4"]
    shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", at_a_terminal(40, words, tmp_path))
    assert max(map(len, shown.splitlines())) <= 40
    for told in ("tick 5", "vr.box.x: nothing yet", "vr.contacts: nothing yet", "Ctrl-C"):
        assert told in shown
