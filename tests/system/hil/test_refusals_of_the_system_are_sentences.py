"""What the system does not allow is said in a sentence with the remedy, and nothing fails."""

from __future__ import annotations

import json
import subprocess
import sys

CODE = """
import json, os, resource, sys
from cosim.base.system.grants import prepare_loop
resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))
if os.getuid() == 0:
    import ctypes
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(24, 23, 0, 0, 0)  # drop CAP_SYS_NICE ...
    libc.prctl(24, 14, 0, 0, 0)  # ... and CAP_IPC_LOCK from what a new user may have
    os.setuid(65534)
print(json.dumps([(g.name, g.granted, g.sentence) for g in prepare_loop()]))
"""


def test_a_user_without_privileges_is_told_how_to_get_them():
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True)
    grants = {name: (granted, text) for name, granted, text in json.loads(done.stdout)}
    assert grants["garbage"][0]
    assert not grants["memory"][0]
    assert "ulimit -l" in grants["memory"][1]
    assert not grants["priority"][0]
    assert "ulimit -r" in grants["priority"][1]
    assert grants["burst"][0]
    assert "killed" in grants["burst"][1]


def test_the_only_processor_is_never_pinned_to():
    code = (
        "import os; os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\n"
        "from cosim.base.system.grants import pin; print(pin())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "one processor only" in done.stdout
