"""Two real stations with an attacker between their sockets: no loop ends, everybody comes back."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from cosim.link.wire.address import Address
from cosim.record import open_run
from cosim.testing.proxy import Proxy
from tests.support.link.attacker import Attacker, Hardest
from tests.support.link.processes import (
    NAMES,
    Listener,
    check_bounds,
    check_steps,
    free_ports,
    link_of,
    station,
)
from tests.support.link.silences import BACK, closed_by, longest_silence, without
from tests.support.link.whole import MILLISECOND, SECOND
from tests.support.machine import timed

JOIN = BACK + 2500 * MILLISECOND + 1400 * MILLISECOND
"""Until somebody looks whether a session is dead, a start, and its ramp."""
TICK_NS = 1e9 / 1024
LAST = 64 * MILLISECOND
"""Before the first of them ends."""
STALL = 0.015
"""A machine that wakes a process so late (s) keeps values back for as long as the hold lasts."""


class Direction:
    """One direction of an attacker, in time since both looked for each other."""

    def __init__(self, attacker: Attacker, source: str, target: str) -> None:
        self.attacker, self.ends = attacker, (source, target)
        self.began = time.monotonic_ns()

    def take(self, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        if len(datagram) < 24:
            return [(now, datagram)]
        treated = self.attacker.treat(*self.ends, datagram, now - self.began)
        return [(due + self.began, content) for due, content in treated]


class Processes:
    """What an attacker does to a simulated world, done to two processes and the proxy between."""

    def __init__(self, attacker: Attacker, out: Path) -> None:
        self.out = out
        self.attacker = attacker
        self.began = 0
        """When both looked for each other (ns)."""
        ports = free_ports()
        there, back = (Direction(self.attacker, *ends) for ends in (NAMES[::-1], NAMES))
        self.directions = there, back
        self.proxy = Proxy(Address("127.0.0.1", 0), Address("127.0.0.1", ports[0]), there, back)
        self.ports = {
            "station_a": (ports[0], self.proxy.inner_address.port),
            "station_b": (self.proxy.address.port, ports[1]),
        }
        self.wire = SimpleNamespace(now=0, put=self._put)
        self.stations: dict[str, Listener] = {}
        self.folders: dict[str, Path] = {}
        """Of those that live."""
        self.records: list[Path] = []
        """Of everybody."""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._relay)

    def _relay(self) -> None:
        # The attacker is as punctual as the loops are, or he is the network's worst part.
        with contextlib.suppress(OSError, AttributeError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(60))
        self.proxy.run(self._stop)

    def _put(self, _due: int, _source: str, target: str, content: bytes) -> None:
        self.proxy.send(content, is_forward=target == "station_a")

    def start(self, name: str) -> None:
        folder = self.out / str(len(self.records))
        process = station(name, self.ports[name], folder, "--realtime", "--duration", "60")
        self.stations[name] = Listener(process)
        self.folders[name] = folder / name
        self.records.append(folder / name)

    def kill(self, name: str) -> None:
        found = self.stations.pop(name, None)
        if found is not None:
            found.kill()

    def run(self) -> int:
        """The attacker's schedule, and the time that all need after it; when that begins (ns)."""
        self._thread.start()
        for name in NAMES:
            self.start(name)
        self._wait_for(self.waiting)
        began = self.began = time.monotonic_ns()
        for direction in self.directions:
            direction.began = began
        for at, act in sorted(self.attacker.events(self), key=lambda event: event[0]):
            self.wire.now = at
            time.sleep(max(0.0, (began + at - time.monotonic_ns()) * 1e-9))
            act()
        self._wait_for(self.waiting)
        since = [each.waits_since or 0 for each in self.stations.values()]
        calm = max(began + self.attacker.calm, *since) + JOIN
        time.sleep(max(0.0, (calm + SECOND - time.monotonic_ns()) * 1e-9))
        return calm

    def closed(self) -> list[tuple[int, int]]:
        """When the attacker let nothing through (ns)."""
        return [(self.began + a, self.began + b) for a, b in closed_by(self.attacker)]

    def waiting(self) -> bool:
        return all(each.waits_since is not None for each in self.stations.values())

    def _wait_for(self, condition) -> None:
        end = time.monotonic() + 60.0
        while not condition():
            said = {name: each.words for name, each in self.stations.items()}
            assert time.monotonic() < end, said
            assert all(each.process.poll() is None for each in self.stations.values()), said
            time.sleep(0.01)

    def close(self) -> None:
        for each in self.stations.values():
            each.kill()
        self._stop.set()
        self._thread.join()


def survive(attacker: Attacker, out: Path) -> bool | str:
    """One schedule; a sentence where the forces did not come back in time."""
    world = Processes(attacker, out)
    try:
        calm = world.run()
        end = time.monotonic_ns()
        codes = {name: each.stop() for name, each in world.stations.items()}
        words = {name: each.words for name, each in world.stations.items()}
    finally:
        world.close()
    # Ended by us, in order, and by nothing before.
    assert codes == dict.fromkeys(NAMES, 1), words
    assert all("Interrupted at tick" in "".join(said) for said in words.values()), words
    for folder in world.records:
        peer = peer_of(folder)
        # Who was killed before the first half second was written has no record.
        if (folder / "run.h5").exists():
            check_bounds(folder, peer)
            check_steps(folder, peer)
    for folder in world.folders.values():
        assert link_of(folder)["peers"][peer_of(folder)]["faulty"] == 0
        assert link_of(folder)["handshake_process"]["absurd"] == 0
    spans = without([(max(map(began, world.folders.values())), end - LAST)], world.closed())
    for folder in world.folders.values():
        name, peer = folder.name, peer_of(folder)
        with open_run(folder) as run:
            weight = np.asarray(run[f"link_{peer}.lan.weight"].values)
            sequence = np.asarray(run[f"link_{peer}.lan.sequence"].values)
        first = began(folder)
        news = [first + round(tick * TICK_NS) for tick in np.flatnonzero(np.diff(sequence)) + 1]
        silence = longest_silence(news, spans)
        if silence > BACK:
            return f"{name} heard nothing of its peer for {silence * 1e-9:.2f} s of an open way"
        back = weight[
            max(0, round((calm - first) / TICK_NS)) : round((end - LAST - first) / TICK_NS)
        ]
        assert len(back) > 256, f"{name} ended before it could come back"
        if back.min() < 1.0:
            return f"{name} saw its peer at {back.min():.3f} when both had been back"
    return True


def peer_of(folder: Path) -> str:
    return NAMES[NAMES[0] == folder.name]


def began(folder: Path) -> int:
    """When a station ran its first tick (ns)."""
    link = link_of(folder)
    return link["epoch"] + round(link["first_tick"] * TICK_NS)


def test_two_processes_survive_what_is_hardest(tmp_path) -> None:
    assert timed(
        lambda number: survive(Hardest(0, list(NAMES), way=MILLISECOND), tmp_path / str(number)),
        tolerates=STALL,
        attempts=4,
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_two_processes_survive_a_drawn_schedule(tmp_path, seed: int) -> None:
    assert timed(
        lambda number: survive(
            Attacker(seed, list(NAMES), way=MILLISECOND), tmp_path / str(number)
        ),
        tolerates=STALL,
        attempts=4,
    )
