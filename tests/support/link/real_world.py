"""Two real stations, and between their sockets somebody who does what he likes to datagrams."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Protocol

import numpy as np

from cosim.link.wire.address import Address
from cosim.record import open_run
from cosim.testing.proxy import Proxy
from tests.support.link.processes import NAMES, Listener, free_ports, link_of, station

TICK_NS = 1e9 / 1024


class Between(Protocol):
    """Whoever sits on the way; times are ns since both stations looked for each other."""

    calm: int
    """From here on he lets everything pass, as it comes."""

    def treat(self, source: str, target: str, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        """When to deliver what in place of a datagram."""
        ...

    def events(self, world: RealWorld) -> list[tuple[int, Callable[[], None]]]:
        """What he does at which time."""
        ...


def be_punctual() -> None:
    """An attacker is as punctual as the loops are, or he is the network's worst part."""
    with contextlib.suppress(OSError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(60))


class Direction:
    """One direction of an attacker, in time since both looked for each other."""

    def __init__(self, attacker: Between, source: str, target: str) -> None:
        self.attacker, self.ends = attacker, (source, target)
        self.began = time.monotonic_ns()

    def take(self, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        if len(datagram) < 24:
            return [(now, datagram)]
        treated = self.attacker.treat(*self.ends, datagram, now - self.began)
        return [(due + self.began, content) for due, content in treated]


class RealWorld:
    """What somebody does to a simulated world, done to two processes and the proxy between."""

    def __init__(self, attacker: Between, out: Path) -> None:
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
        be_punctual()
        self.proxy.run(self._stop)

    def _put(self, _due: int, _source: str, target: str, content: bytes) -> None:
        self.proxy.send(content, is_forward=target == "station_a")

    def start(self, name: str) -> None:
        folder = self.out / str(len(self.records))
        process = station(name, self.ports[name], folder, "--realtime", "--duration", "600")
        self.stations[name] = Listener(process)
        self.folders[name] = folder / name
        self.records.append(folder / name)

    def kill(self, name: str) -> None:
        found = self.stations.pop(name, None)
        if found is not None:
            found.kill()

    def run(self, join: int) -> int:
        """The attacker's schedule, and ``join`` (ns) more for all who live; when that ends (ns)."""
        self._thread.start()
        for name in NAMES:
            self.start(name)
        self._wait_for(self.waiting)
        began = self.began = time.monotonic_ns()
        for direction in self.directions:
            direction.began = began
        for at, act in sorted(self.attacker.events(self), key=lambda event: event[0]):
            time.sleep(max(0.0, (began + at - time.monotonic_ns()) * 1e-9))
            self.wire.now = time.monotonic_ns() - began
            act()
        self._wait_for(self.waiting)
        since = [each.waits_since or 0 for each in self.stations.values()]
        end = max(began + self.attacker.calm, *since) + join
        time.sleep(max(0.0, (end - time.monotonic_ns()) * 1e-9))
        return end

    def waiting(self) -> bool:
        return all(each.waits_since is not None for each in self.stations.values())

    def _wait_for(self, condition) -> None:
        end = time.monotonic() + 200.0
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

    def stop(self) -> str:
        """Ask all who live to end in order, and see that they do; who never ran, in a sentence."""
        codes = {name: each.stop() for name, each in self.stations.items()}
        words = {name: "".join(each.words) for name, each in self.stations.items()}
        # Ended by us, in order, and by nothing before.
        assert all("Interrupted" in said for said in words.values()), words
        for name, code in codes.items():
            if code != 1:
                return f"{name} never ran: {words[name]}"
        return ""


def peer_of(folder: Path) -> str:
    """The other station's name."""
    return NAMES[NAMES[0] == folder.name]


def began(folder: Path) -> int:
    """When a station ran its first tick (ns)."""
    link = link_of(folder)
    return link["epoch"] + round(link["first_tick"] * TICK_NS)


def news_of_peer(folder: Path) -> list[int]:
    """When a station took something new of its peer (ns)."""
    with open_run(folder) as run:
        sequence = np.asarray(run[f"link_{peer_of(folder)}.lan.sequence"].values)
    first = began(folder)
    return [first + round(tick * TICK_NS) for tick in np.flatnonzero(np.diff(sequence)) + 1]
