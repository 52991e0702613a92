"""What one device has, no other gets: not in this process, not in another, not by another name."""

from __future__ import annotations

import errno
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.base.errors import CohapticError
from hil.device.errors import DeviceError
from hil.wire.ownership import OwnedNodes, own_port
from tests.support.hil.driver_bench import DRIVERS, Bench


@pytest.mark.parametrize("name", DRIVERS)
def test_a_second_device_on_the_same_place_is_refused(name: str, bench: Bench):
    emulator = bench.emulator(name)
    first, second = (bench.device(name, emulator) for _ in range(2))
    first.configure()
    with pytest.raises(CohapticError, match=r"(in use by|belongs to) another device"):
        second.configure()
    first.read(0)
    first.write(0, (0.0, 0.0))
    assert first.fault is None, "and it noticed nothing"
    first.close()


@pytest.mark.parametrize("name", ["haply", "odrive"])
def test_another_process_is_refused_by_name_until_the_owner_has_died(name: str, bench: Bench):
    emulator = bench.emulator(name)
    ready, tell = os.pipe()
    owner = os.fork()
    if owner == 0:
        bench.device(name, emulator).configure()
        os.write(tell, b"r")
        signal.pause()
    assert os.read(ready, 1) == b"r"
    try:
        with pytest.raises(DeviceError, match=rf"in use by process {owner}"):
            bench.device(name, emulator).configure()
    finally:
        os.kill(owner, signal.SIGKILL)
        os.waitpid(owner, 0)
    late = bench.device(name, emulator)
    late.configure()
    late.close()


def test_other_nodes_of_the_same_bus_are_free():
    first, second = OwnedNodes("can0", (0, 1)), OwnedNodes("can0", (2, 3))
    with pytest.raises(DeviceError, match="node 1 on can0"):
        OwnedNodes("can0", (4, 1))
    OwnedNodes("can0", (4,)).close()
    for owned in (first, second):
        owned.close()


@pytest.mark.skipif(os.getuid() != 0, reason="another user can be had by root alone")
@pytest.mark.parametrize("kind", ["port", "node"])
def test_another_user_is_refused_as_well(kind: str):
    """Both ways: whoever has it first, the lock is no file that belongs to somebody."""
    ours, theirs = os.openpty()
    port = os.ttyname(theirs)
    Path(port).chmod(0o666)  # as a group "dialout" would have it

    def claim() -> object:
        if kind == "node":
            return OwnedNodes("can0", (3,))
        descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY)
        own_port(descriptor, port)
        return descriptor

    held = claim()
    said = _as_nobody(claim)
    assert f"in use by process {os.getpid()}" in said
    if isinstance(held, OwnedNodes):
        held.close()
    else:
        os.close(held)
    assert _as_nobody(claim) == "taken"
    for descriptor in (ours, theirs):
        os.close(descriptor)


def test_the_owner_is_not_taken_for_one_of_another_file_with_the_same_number(
    tmp_path: Path, monkeypatch
):
    """An inode's number is one on its own file system alone (proc(5), /proc/locks)."""
    ours, theirs = os.openpty()
    port, number = os.ttyname(theirs), os.fstat(theirs).st_ino
    locks = tmp_path / "locks"
    locks.write_text(
        f"1: FLOCK  ADVISORY  WRITE 4242 fe:00:{number} 0 EOF\n" + Path("/proc/locks").read_text()
    )
    own_port(theirs, port)
    locks.write_text(locks.read_text() + Path("/proc/locks").read_text())
    monkeypatch.setattr("hil.wire.ownership._LOCKS", locks)
    second = os.open(port, os.O_RDWR | os.O_NOCTTY)
    with pytest.raises(DeviceError, match="another device of this very run"):
        own_port(second, port)
    for descriptor in (ours, theirs, second):
        os.close(descriptor)


def test_what_else_fails_is_not_said_to_be_in_use(monkeypatch):
    """A process without free descriptors has met no other owner."""

    def none_left(*_: object) -> None:
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr("hil.wire.ownership.socket.socket", none_left)
    with pytest.raises(DeviceError, match="node 1 on can0 cannot be claimed: Too many open files"):
        OwnedNodes("can0", (1,))


def _as_nobody(claim: Callable[[], object]) -> str:
    """What becomes of a claim of the user 65534."""
    read, write = os.pipe()
    process = os.fork()
    if process == 0:
        said = "taken"
        try:
            os.setgroups([])
            os.setresuid(65534, 65534, 65534)
            claim()
        except BaseException as error:
            said = f"{type(error).__name__}: {error}"
        os.write(write, said.encode())
        os._exit(0)
    os.waitpid(process, 0)
    os.close(write)
    with os.fdopen(read) as answer:
        return answer.read()
