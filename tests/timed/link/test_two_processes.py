"""Two real processes on the loopback interface; how well they keep time is measured in bench/."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from cosim.record import open_run
from tests.support.link.processes import (
    COMMAND,
    FADE,
    HOLD,
    NAMES,
    check_bounds,
    cut_power,
    ended,
    free_ports,
    link_of,
    station,
)
from tests.support.machine import timed

pytestmark = pytest.mark.skipif(os.name != "posix", reason="handshakes need a socket pair")

SECONDS = "1.25"
"""Both users have taken hold of the box by then."""
ONE_SAMPLE = 1.0 / 128.0
STALLED = 0.1
"""A loop that was once so late (s) has cost its peer more than a tenth of the run."""


def run_both(out: Path, key: Path, scenario: str, *sets: str) -> Path | str:
    """Both stations of a short run, or in a sentence which of them did not keep time."""
    ports = free_ports()
    options = ("--duration", SECONDS, "--key", str(key), "--set", "expect=~", *sets)
    processes = [station(name, ports, out, *options, scenario=scenario) for name in NAMES]
    ended(processes, 200.0)
    for name in NAMES:
        manifest = json.loads((out / name / "manifest.json").read_text())
        if manifest["link"]["first_tick"] > 0:
            return f"{name} was not ready at the agreed start"
        if manifest["deadlines"]["worst"] > STALLED:
            return f"{name} stood still for {manifest['deadlines']['worst']:.2f} s"
        # Ticks that came later than a packet's sample are not the simulation's.
        if manifest["deadlines"]["worst"] > ONE_SAMPLE:
            return f"{name} was {manifest['deadlines']['worst'] * 1e3:.1f} ms late"
    return out


def guessing(predictor: str | None) -> tuple[str, ...]:
    """Overrides with which both users' workstations guess where the other is, if any."""
    if predictor is None:
        return ()
    return tuple(
        word
        for user in "ab"
        for word in ("--set", f"components.vr_{user}.parameters.predictor={predictor}")
    )


@pytest.mark.parametrize(
    ("scenario", "predictor", "repeats"),
    [
        pytest.param("two_users_box", None, False, id="held"),
        pytest.param("two_users_box", "intent", False, id="intent"),
        pytest.param("thesis/grasp_deadband", None, True, id="deadband"),
    ],
)
def test_two_stations_meet_run_record_and_can_be_merged(
    tmp_path, scenario: str, predictor: str | None, repeats: bool
) -> None:
    key = tmp_path / "key"
    subprocess.run([*COMMAND, "keygen", str(key)], check=True, capture_output=True)
    base = tmp_path
    tmp_path = timed(
        lambda number: run_both(base / f"attempt_{number}", key, scenario, *guessing(predictor)),
        tolerates=2e-3,
    )
    secret = key.read_text().split()[1]
    for name, peer in (("station_a", "station_b"), ("station_b", "station_a")):
        link = link_of(tmp_path / name)
        facts = link["peers"][peer]
        # More where this machine made one side pause for so long that the other looked for it.
        assert link["sessions"] >= 1
        assert facts["streams"]["lan"]["accepted"] > 0
        assert facts["streams"]["lan"]["forged"] == 0
        # What a deadband repeats is not sent, and makes nobody stale.
        assert (facts["withheld"] > 0) is repeats
        assert "stale" not in facts["streams"]["lan"]["lost_because"]
        for path in (tmp_path / name).iterdir():
            assert secret.encode() not in path.read_bytes()
    merged = subprocess.run(
        [
            *(*COMMAND, "merge", str(tmp_path / "station_a"), str(tmp_path / "station_b")),
            *("--out", str(tmp_path / "merged"), "--json"),
        ],
        check=True,
        capture_output=True,
        text=True,
    )
    facts = json.loads(merged.stdout)
    assert facts["ticks"] > 0
    with open_run(tmp_path / "merged") as both, open_run(tmp_path / "station_b") as b:
        first = facts["first_tick"] - link_of(tmp_path / "station_b")["first_tick"]
        own = b["vr_b.box_pose.x"].values[first:]
        assert np.array_equal(both["vr_b.box_pose.x"].values, own[: facts["ticks"]])
        assert "vr_a.box_pose.x" in both
    check_prediction(tmp_path, Path(facts["measured"]), predictor)


def check_prediction(out: Path, measured: Path, predictor: str | None) -> None:
    """With every packet treated as it was here, a simulation gives the very bits of both sides."""
    assert not differing(out, measured)
    if predictor is not None:
        # Without its guesses it is another run: they were made, and alike, over the link.
        assert "vr_a.box_pose.x" in differing(out, measured, *guessing("hold_last"))


def differing(out: Path, measured: Path, *sets: str) -> list[str]:
    """Signals that are not the same bits in a simulation as they were over the link."""
    scenario = out / "merged" / "scenario.resolved.yaml"
    predicted = out / f"predicted_{len(sets)}"
    command = [*COMMAND, "run", str(scenario), "--with", str(measured), "--set", "expect=~"]
    subprocess.run(
        [*command, *sets, "--no-figure", "--out", str(predicted)], check=True, capture_output=True
    )
    with open_run(out / "merged") as real, open_run(predicted) as simulated:
        weights = np.array([real[f"link_{name}.lan.weight"].values for name in NAMES])
        full = weights.min(axis=0) == 1.0
        # From the first packets to where a peer was given up, if one was.
        first = int(np.argmax(full))
        end = first + int(np.argmin([*full[first:], False]))
        assert 0 < first < end
        return [
            signal
            for group in simulated.groups.values()
            for signal in group.signals
            if signal.startswith(("vr_", "finger_"))
            and not np.array_equal(
                np.asarray(real[signal].values)[first:end],
                np.asarray(simulated[signal].values)[first:end],
                equal_nan=True,
            )
        ]


def test_stations_that_would_run_different_things_refuse_with_the_difference(tmp_path) -> None:
    ports = free_ports()
    different = ("--set", "components.vr_a.parameters.local_normal_stiffness=801")
    a = station("station_a", ports, tmp_path, *different)
    b = station("station_b", ports, tmp_path)
    heard = ""
    try:
        _, said = b.communicate()
        while "at station_b" not in heard and (line := a.stderr.readline()):
            heard += line
    finally:
        a.send_signal(signal.SIGINT)
        heard += a.communicate()[1]
    assert b.returncode == 2
    assert "station_a runs something else" in said
    assert re.search(r"local_normal_stiffness\S*: 800.0 at station_b, 801.0 at station_a", said)
    assert "801.0 at station_a, 800.0 at station_b" in heard
    assert "Traceback" not in said + heard
    assert not (tmp_path / "station_b").exists()


def said(process: subprocess.Popen[str], sentence: str) -> None:
    """Read what a station says until it has said that."""
    heard = ""
    while sentence not in heard:
        line = process.stderr.readline()
        assert line, heard
        heard += line


def killed_and_restarted(tmp_path: Path, victim: str) -> bool | str:
    """One run; a sentence where the peer was given up in another time than is stated."""
    ports = free_ports()
    other = {"station_a": "station_b", "station_b": "station_a"}[victim]
    survivor = station(other, ports, tmp_path, "--duration", "30", "--realtime")
    first = station(victim, ports, tmp_path, "--duration", "60", "--realtime")
    said(first, "connected to 1 of 1")
    time.sleep(6.0)
    cut_power(first)
    first.communicate()
    again = station(victim, ports, tmp_path / "again", "--duration", "4", "--realtime")
    ended([survivor, again], 200.0)
    link = link_of(tmp_path / other)
    assert link["sessions"] >= 2
    # The first time nobody said goodbye, the second time somebody did.
    causes = link["peers"][victim]["streams"]["lan"]["lost_because"]
    assert causes["silent"] >= 1
    assert causes["inactive"] == 1
    with open_run(tmp_path / other) as run:
        ticks = run.ticks
        sequence = run[f"link_{victim}.lan.sequence"].values
    weight = check_bounds(tmp_path / other, victim)
    assert len(weight) == ticks
    began = int(np.argmax(weight == 1.0))
    gone = began + int(np.argmax(weight[began:] == 0.0))
    assert weight[gone] == 0.0
    # It came back by itself, as slowly as is stated, and left in order at its end.
    assert weight[gone:].max() == 1.0
    last = 1 + int(np.flatnonzero(np.diff(sequence[:gone]))[-1])
    if not HOLD + FADE - 2 <= gone - last <= HOLD + FADE:
        return f"{gone - last} ticks from the last packet until it did not count"
    return True


@pytest.mark.slow
@pytest.mark.parametrize("victim", ["station_a", "station_b"])
def test_killing_and_restarting_one_side_heals_by_itself(tmp_path, victim: str) -> None:
    """All processes of one side are killed at once, as a power cut would."""
    assert timed(
        lambda number: killed_and_restarted(tmp_path / str(number), victim),
        tolerates=5e-3,
        attempts=4,
    )
