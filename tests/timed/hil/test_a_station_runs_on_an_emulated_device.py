"""A station whose pantograph is a device: supervised, safe, and linked to another station.

In lock-step the device counts exchanges and the link's stations wait for each other's packets no
longer than they always do, so that a busy machine slows the run and changes nothing asserted here.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from cosim.record.reader import open_run
from hil.emulation.launch import Emulator
from tests.support.machine import timed
from tests.timed.hil.test_a_scenario_runs_on_an_emulated_device import device_file, emulated

pytestmark = pytest.mark.skipif(os.name != "posix", reason="a station needs fork")

COMMAND = [sys.executable, "-c", "from cosim.cli import main; main()"]


def free_ports() -> tuple[int, int]:
    with socket.socket(type=socket.SOCK_DGRAM) as a, socket.socket(type=socket.SOCK_DGRAM) as b:
        a.bind(("127.0.0.1", 0))
        b.bind(("127.0.0.1", 0))
        return a.getsockname()[1], b.getsockname()[1]


def station(name: str, ports: tuple[int, int], folder: Path, *more: str) -> subprocess.Popen[str]:
    own, other = ports if name == "station_a" else ports[::-1]
    return subprocess.Popen(
        [
            *(*COMMAND, "station", "two_users_box", "--as", name, "--no-realtime", "--no-figure"),
            *("--listen", f"127.0.0.1:{own}", "--peer", f"127.0.0.1:{other}", "--wait", "250"),
            *("--out", str(folder / name), *more),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def on_device(folder: Path, emulator: Emulator) -> list[str]:
    mapping = f"{{url: '{emulator.url}', file: '{device_file(folder, emulator)}'}}"
    return [
        *("--set", f"components.finger_a1.device={mapping}"),
        *("--set", "components.operator_a1=~"),
    ]


def manifest(folder: Path) -> dict:
    return json.loads((folder / "manifest.json").read_text())


def test_two_stations_one_of_them_on_a_device(tmp_path):
    folder = timed(lambda number: one_on_a_device(tmp_path / f"run{number}"), tolerates=5e-3)
    link = manifest(folder / "station_a")["link"]
    assert link["peers"]["station_b"]["streams"]["lan"]["accepted"] > 0


def one_on_a_device(tmp_path: Path) -> Path | str:
    tmp_path.mkdir()
    ports = free_ports()
    with emulated(lockstep=True) as emulator:
        output = ("--enable-output", "--yes")
        a = station("station_a", ports, tmp_path, "--duration", "1.5", *output,
                    *on_device(tmp_path, emulator))  # fmt: skip
        b = station("station_b", ports, tmp_path, "--duration", "1.5")
        said = [process.communicate() for process in (a, b)]
        assert [a.returncode, b.returncode] == [0, 0], said
        state = emulator.control.ask("state")
    assert state["torque"] == [0.0, 0.0]
    with open_run(tmp_path / "station_a") as run:
        assert run.ticks == 1536
        # Homed, active, output enabled, and no fault, from the first tick to the last.
        assert set(run["finger_a1.status"].values) == {11}
        assert np.isfinite(run["vr_a.box_pose.y"].values).all()
        # The emulated operator moves the handle, and only once the stations have met.
        angle = np.asarray(run["finger_a1.joint_angle[1]"].values)
        assert abs(angle[0] - emulator.home[0]) < 2e-3
        assert np.ptp(angle) > 0.01
    for name in ("station_a", "station_b"):
        said = manifest(tmp_path / name)
        if said["link"]["first_tick"] > 0 or said["deadlines"]["worst"] > 0.5:
            return f"{name} did not keep time: nothing may have come in its 1.5 s"
    return tmp_path


def test_a_device_at_a_station_needs_a_permission_as_everywhere(tmp_path):
    with emulated(lockstep=True) as emulator:
        a = station("station_a", free_ports(), tmp_path, "--enable-output",
                    *on_device(tmp_path, emulator))  # fmt: skip
        _, said = a.communicate()
    assert a.returncode != 0
    assert "nobody to confirm it" in said
    assert "Traceback" not in said
    assert not (tmp_path / "station_a").exists()


@pytest.mark.parametrize(
    "victim", ["the command", pytest.param("the loop", marks=pytest.mark.slow)]
)
def test_a_killed_station_leaves_a_record_and_a_device_at_zero(tmp_path, victim):
    """SIGKILL: no handler runs; the record is read with nothing repaired first."""
    ports = free_ports()
    with emulated(lockstep=True) as emulator:
        output = ("--enable-output", "--yes")
        a = station("station_a", ports, tmp_path, *output, *on_device(tmp_path, emulator))
        b = station("station_b", ports, tmp_path)
        folder = tmp_path / "station_a"
        wait_for(lambda: rows(folder) > 600, a)
        before = rows(folder)
        loop, supervisor = loop_of(a.pid)
        os.kill(a.pid if victim == "the command" else loop, signal.SIGKILL)
        said = a.communicate()
        b.send_signal(signal.SIGINT)
        b.communicate()
        wait_for(lambda: not Path(f"/proc/{supervisor}").exists(), None)
        assert emulator.control.ask("state")["torque"] == [0.0, 0.0]
    if victim == "the command":
        assert a.returncode == -signal.SIGKILL
    else:
        assert a.returncode == 1
        assert "killed by SIGKILL" in "".join(said)
    assert "Traceback" not in "".join(said)
    with open_run(folder) as run:
        assert run.ticks >= before
        for name in ("finger_a1.joint_angle[1]", "vr_a.box_pose.y"):
            assert np.isfinite(np.asarray(run[name].values)).all()
    shown = subprocess.run(
        [*COMMAND, "record", "summary", str(folder)], capture_output=True, text=True, check=False
    )
    assert shown.returncode == 0, shown.stderr
    assert "box displacement" in shown.stdout


def rows(folder: Path) -> int:
    """Rows that a reader finds in a record that is being written."""
    try:
        with open_run(folder) as run:
            return run.ticks
    except Exception:
        return 0


def wait_for(condition, process) -> None:
    end = time.monotonic() + 600
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        assert process is None or process.poll() is None, process.communicate()
        time.sleep(0.05)


def loop_of(command: int) -> tuple[int, int]:
    """The processes below a command: loop and supervisor."""
    children: dict[int, list[int]] = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            text = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        children.setdefault(int(text[1]), []).append(int(path.parent.name))
    for supervisor in children[command]:
        for loop in children.get(supervisor, []):
            return loop, supervisor
    raise AssertionError("there is no loop")
