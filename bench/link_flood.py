"""Two stations in real time with and without a flood: misses, lateness, and CPU time a tick.

    uv run python bench/link_flood.py [--duration 10] [--rounds 2]

Between the stations stands a proxy in a process of its own. It passes what they send and, at the
second station, seems to be the first: it adds packets of another key, copies of genuine ones,
forged ones and datagrams of 60 kB, 20 times the link's rate of each of them in turn, and then all
at 200 times the rate. Calm and flooded runs take turns, because a machine has moods.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import random
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from cosim.link.wire.address import Address
from cosim.link.wire.packet import PacketKind
from cosim.testing.proxy import Proxy
from tests.timed.link.test_two_processes import COMMAND, free_ports

RATE = 128
KINDS = ("none", "foreign", "replayed", "forged", "long", "all x200")


class Pass:
    """Passes everything at once; keeps data packets for who wants to play them again."""

    def __init__(self) -> None:
        self.packets: list[bytes] = []

    def take(self, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        if datagram[3] == PacketKind.DATA:
            self.packets.append(datagram)
        return [(now, datagram)]


def datagram(kind: str, packets: list[bytes]) -> bytes:
    newest = packets[-1]
    match kind:
        case "foreign":
            return newest[:8] + random.randbytes(len(newest) - 8)
        case "replayed":
            return random.choice(packets)
        case "forged":
            sequence = int.from_bytes(newest[16:24], "little") + random.randrange(1, 100)
            return newest[:16] + sequence.to_bytes(8, "little") + newest[24:]
        case "long":
            return bytes(60_000)
        case _:
            return datagram(random.choice(("foreign", "replayed", "forged", "long")), packets)


def between(listen: int, target: int, inner: multiprocessing.Queue, kind: str, result) -> None:
    """The process in between: passes, floods, and says how many it sent."""
    stop = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    backward = Pass()
    proxy = Proxy(Address("127.0.0.1", listen), Address("127.0.0.1", target), Pass(), backward)
    inner.put(proxy.inner_address.port)
    rate = RATE * (200 if kind == "all x200" else 20)
    sent, due = 0, 0.0
    # One thread for both: a second one would hold up what passes.
    while not stop.is_set():
        select.select(proxy.sockets, [], [], 5e-4)
        proxy.take_in()
        proxy.release()
        if kind == "none" or len(backward.packets) < RATE:
            continue
        now = time.monotonic()
        # A proxy that was held up does not make up for it in one burst.
        due = max(due or now, now - 0.01)
        while due < now:
            due += 1.0 / rate
            sent += 1
            proxy.send(datagram(kind, backward.packets), is_forward=False)
    proxy.close()
    result.put(sent)


def station(name: str, ports: tuple[int, int], out: Path, duration: float) -> subprocess.Popen:
    return subprocess.Popen(
        [
            *(*COMMAND, "station", "two_users_box", "--as", name, "--no-figure", "--json"),
            *("--listen", f"127.0.0.1:{ports[0]}", "--peer", f"127.0.0.1:{ports[1]}"),
            *("--wait", "60", "--duration", str(duration), "--out", str(out)),
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def once(kind: str, duration: float) -> dict:
    """One run of both stations; what the flooded one has to say."""
    port_a, port_b = free_ports()
    _, front = free_ports()
    inner, result = multiprocessing.Queue(), multiprocessing.Queue()
    proxy = multiprocessing.Process(target=between, args=(front, port_a, inner, kind, result))
    proxy.start()
    with tempfile.TemporaryDirectory() as scratch:
        root = Path(scratch)
        a = station("station_a", (port_a, inner.get()), root / "a", duration)
        b = station("station_b", (port_b, front), root / "b", duration)
        _, _, usage = os.wait4(b.pid, 0)
        a.wait()
        proxy.terminate()
        sent = result.get()
        proxy.join()
        manifest = json.loads((root / "b" / "manifest.json").read_text())
    peer = manifest["link"]["peers"]["station_a"]
    stream = peer["streams"]["lan"]
    deadlines = manifest["deadlines"]
    return {
        "kind": kind,
        "flood": sent,
        "misses": deadlines["misses"],
        "p99": deadlines["p99"] * 1e6,
        "worst": deadlines["worst"] * 1e6,
        "cpu": usage.ru_utime + usage.ru_stime,
        "accepted": stream["accepted"],
        "losses": stream["losses"],
        "counted": sum(stream[k] for k in ("foreign", "forged", "duplicate", "replayed", "late"))
        + peer["flood"]
        + peer["dropped_by_kernel"],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--duration", type=float, default=10.0)
    parser.add_argument("--rounds", type=int, default=2)
    arguments = parser.parse_args()
    ticks = arguments.duration * 1024
    names = ("datagrams", "counted", "accepted", "faded", "misses", "p99 us", "worst us", "more us")
    print("flood     ", *names, sep="  ")
    for _ in range(arguments.rounds):
        for flooded in KINDS[1:]:
            calm = once("none", arguments.duration)
            row = once(flooded, arguments.duration)
            for found in (calm, row):
                more = (found["cpu"] - calm["cpu"]) / ticks * 1e6
                print(
                    f"{found['kind']:10s} {found['flood']:10d} {found['counted']:8d} "
                    f"{found['accepted']:9d} {found['losses']:6d} {found['misses']:7d} "
                    f"{found['p99']:7.0f} {found['worst']:9.0f} {more:8.1f}",
                    flush=True,
                )
    print("more: CPU time a tick beyond that of the calm run just before")


if __name__ == "__main__":
    main()
