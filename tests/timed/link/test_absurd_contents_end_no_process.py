"""Two real stations, and between them somebody who holds the key and sends both what he likes.

To each he is the other one: he shakes hands, agrees on a start, and then speaks authentic nonsense.
"""

from __future__ import annotations

import socket
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from cosim.link.session.keys import create_key_file
from cosim.link.session.negotiator import SessionNegotiator
from cosim.link.stream.bundle import FieldRole, PacketBundle
from cosim.link.stream.fate import Fate
from cosim.link.wire.packet import PacketKind
from cosim.preparation.prepare import prepare
from cosim.scenario import load
from cosim.station.contract import contract_of
from cosim.station.split import split
from tests.support.link.key_holder import KeyHolder
from tests.support.link.processes import NAMES, check_bounds, ended, free_ports, link_of, station

ACTIVE = 11
A_MILLISECOND = 4
"""Packets that each gets; a tick reads up to sixty-four."""


class FalsePeer:
    """Pretends to one real station to be the other one."""

    def __init__(self, own: str, peer: str, key: Path, seed: int) -> None:
        with prepare(load("two_users_box"), recorded=False).simulation as simulation:
            full = simulation.assembly
            half = split(full, own)
        (real,) = half.peers
        (self.bundle,) = real.sends
        self.own, self.peer, self.seed = own, peer, seed
        self.tick_ns = float(self.bundle.tick) * 1e9
        self.link = socket.socket(type=socket.SOCK_DGRAM)
        self.link.bind(("127.0.0.1", 0))
        self.link.setblocking(False)
        self.port = self.link.getsockname()[1]
        self.negotiator = SessionNegotiator(
            {
                "own": own,
                "peers": [peer],
                "key_files": [str(key)],
                "contracts": [contract_of(full, half, real)],
                "tick": str(self.bundle.tick),
                "period": self.bundle.period,
            }
        )
        self.negotiator.agreement.armed = True
        self.holder: KeyHolder | None = None
        self.target: tuple[str, int] = ("127.0.0.1", 0)

    def meet(self) -> bool:
        """Go on with the handshake; whether the real one runs."""
        agreement, now = self.negotiator.agreement, time.monotonic_ns()
        for _, datagram in agreement.poll(now):
            self.link.sendto(datagram, self.target)
        while (datagram := self._receive()) is not None:
            if datagram[3] >= PacketKind.HELLO:
                at = time.monotonic_ns()
                answer = agreement.receive(self.peer, datagram, at, at)
                if answer is not None:
                    self.link.sendto(answer, self.target)
        start = agreement.start
        if start is None or now < start.epoch + 100_000_000:
            return False
        keys = agreement.sessions()[self.peer]
        self.holder = KeyHolder(keys, honest(self.bundle), start.epoch, self.seed)
        return True

    def speak(self) -> None:
        """Send one packet, and be deaf."""
        assert self.holder is not None
        now = time.monotonic_ns()
        tick = int((now - self.holder.epoch) / self.tick_ns)
        self.link.sendto(self.holder.datagram(tick, now), self.target)
        while self._receive() is not None:
            pass

    def _receive(self) -> bytes | None:
        try:
            return self.link.recv(2048)
        except OSError:
            return None


def honest(bundle: PacketBundle) -> list[float | None]:
    values: list[float | None] = np.clip(
        0.0, bundle.spread("minimum"), bundle.spread("maximum")
    ).tolist()
    for place in bundle.indices(FieldRole.SOURCE_TICK):
        values[place] = None
    for place in bundle.indices(FieldRole.STATUS):
        values[place] = float(ACTIVE)
    return values


def fuzz(peers: list[FalsePeer], processes: list[subprocess.Popen[str]], count: int) -> None:
    """Meet both, then send ``count`` packets to each, a few a millisecond."""
    waiting = list(peers)
    while waiting:
        assert [process.poll() for process in processes] == [None, None]
        waiting = [peer for peer in waiting if not peer.meet()]
        time.sleep(0.002)
    due = time.monotonic()
    for _ in range(count // A_MILLISECOND):
        for peer in peers:
            for _ in range(A_MILLISECOND):
                peer.speak()
        due = max(due + 1e-3, time.monotonic() - 5e-3)
        time.sleep(max(0.0, due - time.monotonic()))
    # Both are still there, and go on alone to their ends.
    assert [process.poll() for process in processes] == [None, None]


@pytest.mark.parametrize("count", [8_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_two_processes_live_on_and_count_all(tmp_path, count: int) -> None:
    key = tmp_path / "key"
    create_key_file(key)
    peers = [
        FalsePeer(own, peer, key, seed) for seed, (own, peer) in enumerate((NAMES[::-1], NAMES))
    ]
    ports = free_ports()
    # Twice the time that an idle machine needs, in which they are spoken to or alone.
    more = ("--key", str(key), "--duration", str(6 + 2 * count // (1000 * A_MILLISECOND)))
    processes = []
    for peer, port in zip(peers, ports, strict=True):
        peer.target = ("127.0.0.1", port)
        own = (port, peer.port)
        pair = own if peer.peer == NAMES[0] else own[::-1]
        processes.append(station(peer.peer, pair, tmp_path, *more))
    try:
        fuzz(peers, processes, count)
    finally:
        ended(processes, 250.0)
        for peer in peers:
            peer.link.close()
    for peer in peers:
        check(tmp_path, peer, count)


def check(folder: Path, false: FalsePeer, count: int) -> None:
    """Everything was counted, and the force and its weight stayed in their bounds."""
    name, holder = false.peer, false.holder
    assert holder is not None
    assert holder.data + holder.keeps == count // A_MILLISECOND * A_MILLISECOND
    link = link_of(folder / name)
    facts = link["peers"][false.own]
    assert facts["faulty"] == facts["foreign"] == 0
    assert link["handshake_process"]["absurd"] == 0
    (stream,) = facts["streams"].values()
    judged = sum(stream[f.name.lower()] for f in Fate if f is not Fate.SUPERSEDED)
    unread = facts["flood"] + facts["dropped_by_kernel"]
    assert judged <= holder.data <= judged + unread
    if not unread:
        assert judged == holder.data
    assert unread < count // 4, "the machine was too slow for the test to say anything"
    for fate in ("absurd", "late", "out_of_range", "accepted"):
        assert stream[fate] > count // 100, fate
    handshakes = link["handshake_process"]
    assert handshakes[false.own]["stray"] + handshakes["dropped"] > 0
    weight = check_bounds(folder / name, false.own)
    assert weight[-1] == 0.0
