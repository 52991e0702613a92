"""Real stations of ``two_users_box``, one process each, and what their records may hold."""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np

from cosim.record import open_run

COMMAND = [sys.executable, "-c", "from cosim.cli import main; main()"]
NAMES = ("station_a", "station_b")
HOLD, FADE, RESUME = 5 * 8, 52, 1024
"""Base ticks: of a sample and four that are held, of the fade, of the way back."""
MAX_FORCE = 2.5
"""N, the start value of ``max_force``."""
OWN = (800.0, 3.0)
"""N/m and N·s/m, normal, between a finger and the own copy of the box."""
PEERS = (170.0, 3.0)
"""Between a peer's finger and the own copy."""
COPIES = (77.5, 10.0)
"""Between the two copies."""
FRICTION = 0.6
TIP_SPEED = 0.3
"""m/s, the fastest that a peer's tip moves."""
CORNER = 0.071
"""m, from the box's centre."""
TICK = 1.0 / 1024
PORTS = range(20_000, 30_000)
"""Below those that the system gives to whoever asks for any."""


def free_ports(count: int = 2) -> tuple[int, ...]:
    """UDP ports that nobody has now, and nobody is given who does not ask for them by number."""
    found: list[int] = []
    while len(found) < count:
        port = random.SystemRandom().choice(PORTS)
        with socket.socket(type=socket.SOCK_DGRAM) as trial, contextlib.suppress(OSError):
            trial.bind(("127.0.0.1", port))
            found += [port] * (port not in found)
    return tuple(found)


def station(
    name: str,
    ports: tuple[int, ...],
    out: Path,
    *more: str,
    scenario: str = "two_users_box",
) -> subprocess.Popen[str]:
    """Start a station; ``ports`` are those of station_a and station_b as it shall see them."""
    own, other = ports if name == "station_a" else ports[::-1]
    return subprocess.Popen(
        [
            *(*COMMAND, "station", scenario, "--as", name),
            *("--listen", f"127.0.0.1:{own}", "--peer", f"127.0.0.1:{other}"),
            *("--no-realtime", "--no-figure", "--wait", "250", "--out", str(out / name), *more),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def link_of(folder: Path) -> dict:
    """What a station's manifest says of its link."""
    return json.loads((folder / "manifest.json").read_text())["link"]


def ended(processes: list[subprocess.Popen[str]], timeout: float) -> list[tuple[str, str]]:
    """What they said, once all have ended well; one that ended badly ends the others."""
    end = time.monotonic() + timeout
    while any(process.poll() is None for process in processes):
        bad = any(process.poll() not in {None, 0} for process in processes)
        if bad or time.monotonic() > end:
            for process in processes:
                process.kill()
        time.sleep(0.05)
    outputs = [process.communicate() for process in processes]
    assert [process.returncode for process in processes] == [0] * len(processes), outputs
    return outputs


def cut_power(process: subprocess.Popen[str]) -> None:
    """Kill a station and all that it has started, at once: nothing says goodbye."""
    everybody = [process.pid]
    for number in everybody:
        for children in Path(f"/proc/{number}/task").glob("*/children"):
            with contextlib.suppress(OSError):
                everybody += [int(word) for word in children.read_text().split()]
    for number in everybody:
        with contextlib.suppress(ProcessLookupError):
            os.kill(number, signal.SIGKILL)


class Listener:
    """A station's process whose words are heard as they come."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process
        self.words: list[str] = []
        self.waits_since: int | None = None
        """ns: when it looked for its peers first."""
        self._thread = threading.Thread(target=self._listen)
        self._thread.start()

    def _listen(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.words.append(line)
            if self.waits_since is None and "waiting for" in line:
                self.waits_since = time.monotonic_ns()

    def kill(self) -> None:
        """End it as a power cut would."""
        cut_power(self.process)
        self.close()

    def stop(self) -> int:
        """Ask it to end in order; its exit status."""
        with contextlib.suppress(ProcessLookupError):
            self.process.send_signal(signal.SIGINT)
        self.process.wait(120)
        self.close()
        return self.process.returncode

    def close(self) -> None:
        """Wait for its last word."""
        self.process.wait()
        self._thread.join()
        for pipe in (self.process.stdout, self.process.stderr):
            assert pipe is not None
            pipe.close()


def check_bounds(folder: Path, peer: str) -> np.ndarray:
    """The peer's weight at every tick, once it and the forces were found within their bounds."""
    name = folder.name
    with open_run(folder) as run:
        weight = np.asarray(run[f"link_{peer}.lan.weight"].values)
        forces = [
            np.hypot(*(run[f"vr_{name[-1]}.finger_{f}.force[{axis}]"].values for axis in (1, 2)))
            for f in (1, 2)
        ]
        assert all(len(force) == run.ticks for force in forces)
    assert all(np.isfinite(force).all() and force.max() <= MAX_FORCE + 1e-9 for force in forces)
    steps = np.diff(weight)
    # The very start is no return: both begin at tick 0 with the values from before.
    starts = (weight[:-1] == 0.0) & (weight[1:] == 1.0)
    assert starts.sum() <= 1
    assert steps[~starts].max(initial=0.0) <= 1.01 / RESUME
    assert steps.min(initial=0.0) >= -1.01 / FADE
    return weight


def check_steps(folder: Path, peer: str) -> None:
    """What one tick changes of the force on a finger, and of what comes from the peer.

    The peer reaches a finger through the mass of the box alone: the force grows and falls no more
    than where the two meet at the speed that they have, with friction, unless the finger slides off
    an edge. What comes from the peer changes as docs/protocol.md says, with the couplers of
    ``two_users_box``.
    """
    user = f"vr_{folder.name[-1]}"
    with open_run(folder) as run:

        def vector(first: str, second: str) -> np.ndarray:
            return np.array([run[f"{user}.{each}"].values for each in (first, second)])

        weight = np.asarray(run[f"link_{peer}.lan.weight"].values)
        fingers = [vector(f"finger_{n}.force[1]", f"finger_{n}.force[2]") for n in (1, 2)]
        places = [
            vector("peer_1.box_x", "peer_1.box_y"),
            *(
                vector(f"peer_1.finger_{n}_position[1]", f"peer_1.finger_{n}_position[2]")
                for n in (1, 2)
            ),
        ]
        losses = [run[f"{user}.finger_{n}.contact_losses"].values for n in (1, 2)]
        wrench = vector("coupling_wrench.x", "coupling_wrench.y")
        turns = np.abs(run[f"{user}.box_velocity.theta"].values)
        tips = [vector(f"finger_{n}.velocity[1]", f"finger_{n}.velocity[2]") for n in (1, 2)]
        moves = np.hypot(*vector("box_velocity.x", "box_velocity.y")) + CORNER * turns

    def step(values: np.ndarray) -> np.ndarray:
        return np.hypot(*np.diff(values))

    slip = np.hypot(1.0, FRICTION)
    stiffness, damping = OWN
    for force, tip, lost in zip(fingers, tips, losses, strict=True):
        speed = np.hypot(*tip).max(initial=0.0) + moves.max(initial=0.0)
        met = slip * (stiffness * TICK + damping) * speed
        growth = np.diff(np.hypot(*force))
        assert growth.max(initial=0.0) <= met
        assert (np.diff(lost)[growth < -met] > 0).all()
    counts = (weight[:-1] > 0.0) & (weight[1:] > 0.0)
    reach = TIP_SPEED * HOLD * TICK
    assert all(step(place)[counts].max(initial=0.0) <= reach for place in places)
    a_finger, copies = (k * reach + b * TIP_SPEED for k, b in (PEERS, COPIES))
    moved = 2.0 * slip * a_finger + copies
    given_up = np.where(np.diff(weight) < 0.0, np.hypot(*wrench).max(initial=0.0) / FADE, 0.0)
    assert (step(wrench) <= moved + given_up).all()
