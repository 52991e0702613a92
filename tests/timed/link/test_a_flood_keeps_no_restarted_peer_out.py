"""Floods at twenty times the rate from the peer's own address: who is restarted joins in 3 s."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.link.wire.packet import HEADER, PacketKind
from tests.support.link.processes import NAMES, check_bounds, check_steps, link_of
from tests.support.link.real_world import RealWorld, be_punctual, began, news_of_peer
from tests.support.link.whole import MILLISECOND, SECOND
from tests.support.machine import timed
from tests.support.others import others_probe

REJOIN = 3 * SECOND
"""Since both look for each other."""
RATE = 20 * 128
KILL = 2500 * MILLISECOND
KINDS = ("junk", "short junk", "replay", "greetings")
OTHERS = 1.0
"""Processors; where others take more of two, processes that start and shake hands wait for them."""


class Flooder:
    """Lets all pass, and sends both ends what looks like the other one's, from its address."""

    def __init__(self, kind: str, victim: str) -> None:
        self.kind, self.victim = kind, victim
        self.calm = KILL
        self.over = threading.Event()
        self.thread: threading.Thread | None = None
        self.draw = random.Random(5)
        self.recorded: dict[str, list[bytes]] = {name: [] for name in NAMES}
        self.greetings: dict[str, list[bytes]] = {name: [] for name in NAMES}
        self.sent = dict.fromkeys(NAMES, 0)

    def treat(self, source: str, target: str, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        self.recorded[target].append(datagram)
        if PacketKind.HELLO <= datagram[3] <= PacketKind.COOKIE:
            self.greetings[target].append(datagram)
        return [(now + MILLISECOND, datagram)]

    def datagram(self, target: str) -> bytes:
        kind = self.draw.choice(KINDS) if self.kind == "mixed" else self.kind
        if kind == "junk":
            asked = self.draw.choice([PacketKind.HELLO, PacketKind.REPLY, PacketKind.REFUSE])
            return HEADER.pack(b"cH", 2, asked, 0, 0, 5, 0) + self.draw.randbytes(1176)
        kept = {"replay": self.recorded, "greetings": self.greetings}.get(kind)
        if kept is None or not kept[target]:
            return self.draw.randbytes(80)
        return self.draw.choice(kept[target])

    def events(self, world: RealWorld) -> list[tuple[int, Callable[[], None]]]:
        def flood() -> None:
            be_punctual()
            begin = time.monotonic_ns()
            while not self.over.wait(2e-3):
                due = RATE * (time.monotonic_ns() - begin) // SECOND
                for target in NAMES:
                    for _ in range(due - self.sent[target]):
                        self.sent[target] += 1
                        world.wire.put(0, "", target, self.datagram(target))

        self.thread = threading.Thread(target=flood)
        return [
            (0, self.thread.start),
            (KILL, lambda: world.kill(self.victim)),
            (KILL, lambda: world.start(self.victim)),
        ]

    def close(self) -> None:
        """End the flood."""
        self.over.set()
        if self.thread is not None:
            self.thread.join()


def rejoins(kind: str, victim: str, out: Path) -> bool | str:
    """One run; a sentence where the restarted one came too late."""
    flooder = Flooder(kind, victim)
    world = RealWorld(flooder, out)
    try:
        end = world.run(REJOIN + SECOND // 2)
        since = max(each.waits_since or 0 for each in world.stations.values())
        flooder.close()
        never = world.stop()
    finally:
        flooder.close()
        world.close()
    if never:
        return never
    assert min(flooder.sent.values()) >= 0.99 * RATE * (end - world.began) / SECOND
    survivor, restarted = (
        world.folders[name] for name in sorted(NAMES, key=lambda name: name == victim)
    )
    for folder, peer in ((survivor, victim), (restarted, survivor.name)):
        facts = link_of(folder)["peers"][peer]
        assert facts["faulty"] == 0
        check_bounds(folder, peer)
        check_steps(folder, peer)
    heard = [at for at in news_of_peer(survivor) if at > since]
    met = max(began(restarted), heard[0] if heard else end)
    if met > since + REJOIN:
        return f"{victim} was back after {(met - since) * 1e-9:.2f} s"
    return True


@pytest.mark.parametrize(
    ("kind", "victim"),
    [
        ("mixed", "station_a"),
        *(pytest.param(kind, victim, marks=pytest.mark.slow) for kind in KINDS for victim in NAMES),
    ],
)
def test_a_restarted_peer_is_back_in_three_seconds(tmp_path, kind: str, victim: str) -> None:
    assert timed(
        lambda number: rejoins(kind, victim, tmp_path / str(number)),
        tolerates=OTHERS,
        attempts=4,
        probing=others_probe,
    )
