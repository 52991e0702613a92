"""``cohaptic doctor`` judges what it finds; what is not good says what to do."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.cli import cli
from hil.setup.doctor import machine
from hil.setup.doctor.can import can_notes
from hil.setup.doctor.lateness import Wakings, lateness_note
from hil.setup.doctor.machine import machine_notes
from hil.setup.doctor.ports import port_notes


def tree(root: Path, **files: str) -> Path:
    """A tree of the kernel's files; ``__`` stands for a slash."""
    for name, text in files.items():
        path = root / name.replace("__", "/")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text + "\n")
    return root


def health(notes) -> dict[str, str]:
    return {note.name: note.health for note in notes}


def test_kernels_are_told_apart(tmp_path):
    plain = tree(tmp_path / "a", proc__sys__kernel__osrelease="6.1", proc__version="#1 SMP")
    dynamic = tree(
        tmp_path / "b", proc__sys__kernel__osrelease="6.1", proc__version="SMP PREEMPT_DYNAMIC"
    )
    real = tree(tmp_path / "c", proc__sys__kernel__osrelease="6.1", sys__kernel__realtime="1")
    assert health(machine_notes(plain))["kernel"] == "poor"
    assert health(machine_notes(dynamic))["kernel"] == "good"
    assert health(machine_notes(real))["kernel"] == "good"


@pytest.mark.parametrize(("governor", "is_good"), [("performance", True), ("powersave", False)])
def test_a_sleepy_governor_is_named(tmp_path, governor, is_good):
    root = tree(tmp_path, sys__devices__system__cpu__cpu0__cpufreq__scaling_governor=governor)
    (note,) = [each for each in machine_notes(root) if each.name == "governor"]
    assert (note.health == "good") == is_good
    assert is_good or "cpupower frequency-set -g performance" in note.sentence


@pytest.mark.parametrize(
    ("name", "limit", "granted"),
    [("rtprio", "RLIMIT_RTPRIO", 0), ("memlock", "RLIMIT_MEMLOCK", 65536)],
)
def test_what_is_not_granted_says_where_to_write_it(tmp_path, monkeypatch, name, limit, granted):
    monkeypatch.setattr(machine.os, "geteuid", lambda: 1000)
    monkeypatch.setattr(machine, "_limit", lambda which: granted if which == limit else -1)
    notes = {note.name: note for note in machine_notes(tmp_path)}
    assert notes[name].health != "good"
    assert "log in again" in notes[name].sentence
    assert all(notes[other].health == "good" for other in {"rtprio", "memlock"} - {name})


def test_throttling_that_is_off_is_no_virtue(tmp_path):
    root = tree(tmp_path, proc__sys__kernel__sched_rt_runtime_us="-1")
    assert health(machine_notes(root))["throttling"] == "poor"


def test_a_slow_adapter_and_a_modem_manager_are_named(tmp_path):
    files = {
        "dev__ttyUSB0": "",
        "sys__bus__usb-serial__devices__ttyUSB0__latency_timer": "16",
        "proc__77__comm": "ModemManager",
    }
    root = tree(tmp_path, **files)
    notes = {note.name: note for note in port_notes(root)}
    assert notes["latency"].health == "poor"
    assert "waits 16 ms" in notes["latency"].sentence
    assert notes["modem manager"].health == "bad"
    tree(root, **{"etc__udev__rules.d__99-board.rules": 'ENV{ID_MM_DEVICE_IGNORE}="1"'})
    tree(root, **{"sys__bus__usb-serial__devices__ttyUSB0__latency_timer": "1"})
    assert set(health(port_notes(root)).values()) == {"good"}
    (tmp_path / "empty").mkdir()
    assert health(port_notes(tmp_path / "empty")) == {"ports": "good"}


def test_a_can_interface_is_looked_at(tmp_path):
    def interface(flags: str, queue: int):
        place = "sys__class__net__can0__"
        return tree(
            tmp_path,
            **{
                f"{place}type": "280",
                f"{place}flags": flags,
                f"{place}operstate": "up",
                f"{place}tx_queue_len": str(queue),
            },
        )

    def said(state: str, restart: int):
        return {"can0": {"linkinfo": {"info_data": {"state": state, "restart_ms": restart}}}}

    down = health(can_notes(interface("0x80", 10), {}))
    assert down == {"can": "bad", "txqueuelen": "good"}
    fine = health(can_notes(interface("0x81", 10), said("ERROR-ACTIVE", 0)))
    assert set(fine.values()) == {"good"}
    ill = health(can_notes(interface("0x81", 1000), said("BUS-OFF", 100)))
    assert ill == {"can": "good", "txqueuelen": "poor", "can state": "bad", "can restart": "poor"}


@pytest.mark.parametrize(
    ("p99", "worst", "expected"),
    [(50e-6, 2e-3, "good"), (500e-6, 2e-3, "poor"), (50e-6, 30e-3, "bad")],
)
def test_lateness_is_judged_by_what_a_run_needs(p99, worst, expected):
    assert lateness_note(Wakings(ticks=9, median=1e-5, p99=p99, worst=worst)).health == expected


def test_the_command_ends_with_a_verdict():
    done = CliRunner().invoke(cli, ["doctor", "--seconds", "0.3", "--json"], standalone_mode=False)
    said = json.loads(done.stdout)
    names = {note["name"] for note in said["notes"]}
    assert {"kernel", "rtprio", "memlock", "governor", "ports", "can", "lateness"} <= names
    assert said["verdict"] in {"good", "poor", "bad"}
    assert done.exit_code == (said["verdict"] == "bad")
