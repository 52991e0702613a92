"""Kernel, priorities, memory and processors. ``root`` stands before /proc and /sys, for tests."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from hil.setup.doctor.note import DoctorNote, bad, good, poor

PRIORITY = 80
"""What the loop (70), its supervisor (75) and some room above them take."""
UNLIMITED = -1


def machine_notes(root: Path = Path("/")) -> Iterator[DoctorNote]:
    """Everything about the machine itself."""
    yield _kernel(root)
    yield _rtprio()
    yield _memlock()
    yield _throttling(root)
    yield _processors()
    yield from _governors(root)


def _kernel(root: Path) -> DoctorNote:
    if sys.platform != "linux":
        return bad("kernel", f"{sys.platform}: devices are given force on Linux alone")
    name = read(root / "proc/sys/kernel/osrelease") or "unknown"
    version = read(root / "proc/version") or ""
    if (read(root / "sys/kernel/realtime") or "0") == "1" or "PREEMPT_RT" in version:
        return good("kernel", f"Linux {name} with PREEMPT_RT")
    if "PREEMPT" in version:
        return good(
            "kernel", f"Linux {name}, preemptible; a kernel with PREEMPT_RT is late less often"
        )
    return poor(
        "kernel", f"Linux {name} is not preemptible: take one with PREEMPT_DYNAMIC or PREEMPT_RT"
    )


def _limit(name: str) -> int:
    import resource

    return resource.getrlimit(getattr(resource, name))[0]


def _rtprio() -> DoctorNote:
    if os.geteuid() == 0:
        return good("rtprio", "root may ask for any real-time priority")
    granted = _limit("RLIMIT_RTPRIO")
    if granted in {UNLIMITED} or granted >= PRIORITY:
        return good("rtprio", f"real-time priorities up to {granted} are granted")
    return bad(
        "rtprio",
        f"real-time priorities up to {granted} are granted, {PRIORITY} are needed: write "
        f"'@realtime - rtprio {PRIORITY}' into /etc/security/limits.d/99-realtime.conf, join the "
        "group 'realtime', and log in again",
    )


def _memlock() -> DoctorNote:
    granted = _limit("RLIMIT_MEMLOCK")
    if granted == UNLIMITED or os.geteuid() == 0:
        return good("memlock", "all memory may be locked")
    return poor(
        "memlock",
        f"only {granted // 1024} KiB of memory may be locked, so that a page may be fetched from "
        "disk in the loop: write '@realtime - memlock unlimited' beside rtprio, and log in again",
    )


def _throttling(root: Path) -> DoctorNote:
    runtime = read(root / "proc/sys/kernel/sched_rt_runtime_us")
    if runtime == "-1":
        return poor(
            "throttling",
            "real-time throttling is off: a loop that runs away would take the machine with it; "
            "'sysctl kernel.sched_rt_runtime_us=950000' brings it back",
        )
    return good("throttling", "real-time throttling is on")


def _processors() -> DoctorNote:
    count = (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    )
    if count < 2:
        return bad("processors", "there is one processor: the loop needs one besides the others")
    return good("processors", f"{count} processors")


def _governors(root: Path) -> Iterator[DoctorNote]:
    places = sorted((root / "sys/devices/system/cpu").glob("cpu[0-9]*/cpufreq/scaling_governor"))
    found = {read(place) or "unknown" for place in places}
    if not found:
        yield good("governor", "the processors' frequency is not scaled by this system")
    elif found == {"performance"}:
        yield good("governor", "the processors stay at their full frequency")
    else:
        yield poor(
            "governor",
            f"the processors' governor is {', '.join(sorted(found))}: they are slow to wake; "
            "'cpupower frequency-set -g performance' keeps them awake",
        )


def read(path: Path) -> str | None:
    """What stands in a file of the kernel's, ``None`` where it is not there."""
    with suppress(OSError):
        return path.read_text("utf-8", "replace").strip()
    return None
