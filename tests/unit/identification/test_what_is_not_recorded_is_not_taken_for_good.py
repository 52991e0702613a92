"""Which rows count is read from the record; of a device nobody guesses it, nor its latency."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from cohaptic.described import described
from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.identification import records
from cosim.identification.records import recording
from cosim.identification.results import identify
from cosim.scenario import Kind
from tests.support.identification.known import DEVICE, changed, known

ROWS = 5
PAIRS = [f"finger.{each}[{i}]" for each in ("joint_angle", "applied_torque") for i in (1, 2)]
WHOLE = ["finger.sample_age", "finger.status"]


class Record:
    """The part of a run that is read, of constant signals; ``slow`` ones at another rate."""

    folder, manifest = Path("runs/bare"), {"started": "2026-11-27T10:00:00"}

    def __init__(self, *names: str, slow: str = "") -> None:
        ticks = np.arange(ROWS)
        groups = {
            rate: SimpleNamespace(name=f"g{rate}", rate=Fraction(rate), ticks=ticks, period=1)
            for rate in (1024, 512)
        }
        self.signals = {
            name: SimpleNamespace(group=groups[512 if name == slow else 1024], values=ticks)
            for name in names
        }

    def __getitem__(self, name: str):
        return self.signals[name]


@pytest.fixture(autouse=True)
def _no_digest(monkeypatch):
    monkeypatch.setattr(records, "digest", lambda run: "0" * 64)


def read(run: Record, kind: Kind, force: str | None = None):
    parts = {"finger": SimpleNamespace(kind=kind), "sensor": SimpleNamespace(kind=Kind.DEVICE)}
    scenario = SimpleNamespace(components=parts)
    return recording(run, scenario, "finger", limit=0.12, payload=None, force=force)[0]


@pytest.mark.parametrize("missing", WHOLE)
def test_a_device_whose_age_or_status_is_not_recorded_is_refused(missing):
    run = Record(*PAIRS, *(name for name in WHOLE if name != missing))
    with pytest.raises(InputError, match=rf"no {missing} in its record"):
        read(run, Kind.DEVICE)


def test_a_simulated_device_has_constants():
    found = read(Record(*PAIRS), Kind.FMU)
    assert not found.age.any()
    assert found.pushing().all()


def test_a_sensor_whose_age_is_not_recorded_is_refused():
    force = ["sensor.force[1]", "sensor.force[2]"]
    with pytest.raises(InputError, match=r"no sensor\.sample_age in its record"):
        read(Record(*PAIRS, *WHOLE, *force), Kind.DEVICE, "sensor.force")
    found = read(Record(*PAIRS, *WHOLE, *force, "sensor.sample_age"), Kind.DEVICE, "sensor.force")
    assert found.force_age.tolist() == list(range(ROWS))


@pytest.mark.parametrize("slow", [*PAIRS[1:], *WHOLE])
def test_a_signal_at_another_rate_is_refused(slow):
    with pytest.raises(InputError, match="at another rate"):
        read(Record(*PAIRS, *WHOLE, slow=slow), Kind.DEVICE)


def test_a_pipelined_buss_tick_is_part_of_the_latency():
    for option, ticks in (("", 0), ("&pipelined=1", 1)):
        url = f"canopen+socketcan://can0?nodes=1,2{option}"
        part = SimpleNamespace(kind=Kind.DEVICE, name="finger", source=url, options={})
        scenario = SimpleNamespace(components={"finger": part})
        assert described(scenario, "finger", None).latency_ticks == ticks


def test_runs_of_different_rates_are_refused():
    run = known()
    with pytest.raises(InputError, match="rates that differ"):
        identify(DEVICE, [run, changed(run, tick=run.tick / 2)], [1, 1])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (("a/r", "a/r"), "named twice"),
        (("a/r", "b/r", "--payload", "r=50g"), "2 runs have that name"),
        (("a/r", "--payload", "r=50g", "--payload", "a/r=40g"), "said before"),
    ],
)
def test_what_is_said_twice_is_refused(given, words):
    with pytest.raises(InputError, match=words):
        CliRunner().invoke(cli, ["identify", *given], catch_exceptions=False, standalone_mode=False)
