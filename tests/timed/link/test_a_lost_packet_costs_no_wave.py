"""Waves travel as integrals between real stations: whatever is lost, the next packet has it all."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cosim.link.wire.address import Address
from cosim.record import Run, open_run
from cosim.testing.impairment import BadNetwork, Impairer
from cosim.testing.proxy import Proxy
from tests.support.link.processes import NAMES, ended, free_ports, link_of, station

PACKETS = {"station_a": "server.to_client_1", "station_b": "client.up"}
"""Who sends what: the server's user is a, the client's is b."""
WAVES = [f"finger_{f}_wave[{axis}]" for f in (1, 2) for axis in (1, 2)]


@contextlib.contextmanager
def lossy(loss: float) -> Iterator[dict[str, tuple[int, ...]]]:
    """The ports that two stations shall see, with a network between them."""
    ports = free_ports()
    ways = [Impairer(BadNetwork(loss=loss), seed) for seed in (1, 2)]
    proxy = Proxy(Address("127.0.0.1", 0), Address("127.0.0.1", ports[0]), *ways)
    stop = threading.Event()
    thread = threading.Thread(target=proxy.run, args=(stop,))
    thread.start()
    try:
        yield {
            "station_a": (ports[0], proxy.inner_address.port),
            "station_b": (proxy.address.port, ports[1]),
        }
    finally:
        stop.set()
        thread.join()
        proxy.close()


def lost_on_the_way(run: Run, sender: Run, shift: int, source: str) -> int:
    """How many packets never came; what did come has the sender's integrals of its tick."""
    packet = PACKETS[source]
    sequence, delay = (run[f"link_{source}.lan.{fact}"].values for fact in ("sequence", "delay"))
    released = 1 + np.flatnonzero(np.diff(sequence))
    sampled = released - delay[released] + shift
    known = (sampled >= 0) & (sampled < sender.ticks)
    assert known.sum() > 100
    moved = 0.0
    for wave in WAVES:
        received = run[f"link_{source}.{packet}.{wave}"].values[released[known]]
        sent = sender[f"{packet}.{wave}"].values[sampled[known]]
        assert np.array_equal(received, sent)
        moved = max(moved, float(np.ptp(sent)))
    assert moved > 0.01
    return int(sequence[released[-1]] - sequence[released[0]] + 1 - len(released))


@pytest.mark.parametrize("loss", [0.0, 0.3])
def test_the_next_packet_has_the_whole_integral(tmp_path: Path, loss: float) -> None:
    with lossy(loss) as seen:
        options = ("--duration", "2", "--realtime")
        scenario = "thesis/grasp_centralized_wave"
        ended([station(n, seen[n], tmp_path, *options, scenario=scenario) for n in NAMES], 200.0)
    first = {name: link_of(tmp_path / name)["first_tick"] for name in NAMES}
    with open_run(tmp_path / "station_a") as a, open_run(tmp_path / "station_b") as b:
        runs = {"station_a": a, "station_b": b}
        for here, there in (NAMES, NAMES[::-1]):
            shift = first[here] - first[there]
            lost = lost_on_the_way(runs[here], runs[there], shift, there)
            assert loss == 0.0 or lost > 20
