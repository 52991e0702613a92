"""Two real processes with an attacker between their sockets: nobody ends, everybody comes back."""

from __future__ import annotations

import json
import threading
import time

import numpy as np
import pytest

from cosim.link.wire.transport import Address
from cosim.record import open_run
from cosim.testing.proxy import Proxy
from tests.support.link.attacker import CALM, Attacker
from tests.support.link.whole import MILLISECOND, SECOND
from tests.timed.link.test_two_processes import free_ports, station

FADE, RESUME, MAX_FORCE = 52, 1024, 2.5
HOLD = 0.03125
NAMES = ("station_a", "station_b")


class Direction:
    """One direction of an attacker, in time since both were started."""

    def __init__(self, attacker: Attacker, source: str, target: str) -> None:
        self.attacker, self.ends = attacker, (source, target)
        self.began = time.monotonic_ns()

    def take(self, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        if len(datagram) < 24:
            return [(now, datagram)]
        treated = self.attacker.treat(*self.ends, datagram, now - self.began)
        return [(due + self.began, content) for due, content in treated]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_two_processes_survive_a_drawn_schedule(tmp_path, seed: int) -> None:
    ports = free_ports()
    attacker = Attacker(seed, list(NAMES), way=MILLISECOND)
    there, back = (Direction(attacker, *ends) for ends in (NAMES[::-1], NAMES))
    proxy = Proxy(Address("127.0.0.1", 0), Address("127.0.0.1", ports[0]), there, back)
    stop = threading.Event()
    thread = threading.Thread(target=proxy.run, args=(stop,))
    thread.start()
    try:
        duration = ("--duration", str(CALM // SECOND + 6))
        processes = [
            station("station_a", (ports[0], proxy.inner_address.port), tmp_path, *duration),
            station("station_b", (proxy.address.port, ports[1]), tmp_path, *duration),
        ]
        outputs = [process.communicate(timeout=120) for process in processes]
    finally:
        stop.set()
        thread.join()
    assert [process.returncode for process in processes] == [0, 0], outputs
    for name, peer in (NAMES, NAMES[::-1]):
        link = json.loads((tmp_path / name / "manifest.json").read_text())["link"]
        assert link["peers"][peer]["faulty"] == 0
        assert link["handshake_process"]["absurd"] == 0
        with open_run(tmp_path / name) as run:
            weight = np.asarray(run[f"link_{peer}.lan.weight"].values)
            forces = [
                np.hypot(
                    *(run[f"vr_{name[-1]}.finger_{f}.force[{axis}]"].values for axis in (1, 2))
                )
                for f in (1, 2)
            ]
        assert max(float(force.max()) for force in forces) <= MAX_FORCE + 1e-9
        steps = np.diff(weight)
        starts = (weight[:-1] == 0.0) & (weight[1:] == 1.0)
        assert starts.sum() <= 1
        assert steps[~starts].max() <= 1.01 / RESUME
        assert steps.min() >= -1.01 / FADE
        # Once he let go everybody came back; a loop that the machine stops for longer than the hold
        # fades, and is on its way back again.
        stalled = any(worst_lateness(tmp_path / each) > HOLD for each in NAMES)
        assert weight[-5 * RESUME :].max() == 1.0 or (stalled and weight[-5 * RESUME :].max() > 0.1)


def worst_lateness(folder) -> float:
    """By how much (s) a loop was late at its worst tick."""
    return json.loads((folder / "manifest.json").read_text())["deadlines"]["worst"]
