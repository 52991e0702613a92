"""How late a loop of 1024 Hz really is here: the wait of the control loop, without a device.

``python -m hil.setup.doctor.lateness SECONDS`` prints it as JSON, from a process of its own.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import dataclass
from typing import Any

from cosim.base.system.grants import clock_nanosleep, prepare_loop
from hil.setup.doctor.note import DoctorNote, bad, good, poor

TICK_NS = 1_000_000_000 // 1024
GOOD_P99, WORST = 250e-6, 10e-3
"""A quarter of a tick; and what ends a run with force."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Wakings:
    """Of one process's wakings (s), and what it was not granted."""

    ticks: int
    median: float
    p99: float
    worst: float
    refused: tuple[str, ...] = ()


def measure(seconds: float) -> Wakings:
    """Sleep until each deadline for some time, and look how late it is then."""
    grants = prepare_loop()
    sleep = clock_nanosleep()
    late: list[int] = []
    due = time.monotonic_ns() + TICK_NS
    for _ in range(round(seconds * 1e9 / TICK_NS)):
        sleep(due)
        now = time.monotonic_ns()
        late.append(now - due)
        due = max(due + TICK_NS, now + TICK_NS - (now - due) % TICK_NS)
    late.sort()
    return Wakings(
        ticks=len(late),
        median=late[len(late) // 2] * 1e-9,
        p99=late[int(0.99 * (len(late) - 1))] * 1e-9,
        worst=late[-1] * 1e-9,
        refused=tuple(grant.name for grant in grants if not grant.granted),
    )


def lateness_of_a_process(seconds: float) -> Wakings:
    """The same in a process of its own, whose priority ends with it."""
    said = subprocess.run(
        [sys.executable, "-m", "hil.setup.doctor.lateness", str(seconds)],
        capture_output=True,
        check=True,
        timeout=seconds + 60,
    )
    found: dict[str, Any] = json.loads(said.stdout)
    refused: list[str] = found.pop("refused")
    return Wakings(refused=tuple(refused), **found)


def lateness_note(found: Wakings) -> DoctorNote:
    """What that means for a device."""
    seen = (
        f"{found.ticks} ticks of 1024 Hz: {found.median * 1e6:.0f} us late (median), "
        f"{found.p99 * 1e6:.0f} (p99), {found.worst * 1e6:.0f} (worst)"
    )
    if found.worst > WORST:
        return bad(
            "lateness",
            f"{seen}: the worst one would have ended a run with force; end what else runs here, "
            "and see to the priorities above",
        )
    if found.p99 > GOOD_P99:
        return poor("lateness", f"{seen}: force will be rough; end what else runs here")
    return good("lateness", seen)


if __name__ == "__main__":
    from dataclasses import asdict

    sys.stdout.write(json.dumps(asdict(measure(float(sys.argv[1])))))
