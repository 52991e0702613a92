"""From a measured network to a simulated one, and to gains that are stable over it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.cli import cli
from cosim.link.netchar.measurement import NetworkMeasurement
from cosim.link.netchar.preset import channel_preset
from cosim.link.netchar.statistics import characterise
from cosim.scenario import load
from cosim.scenario.describe import average
from cosim.testing.impairment import BadNetwork, Impairer
from cosim.theory.chance.network import Network
from tests.support.link.measured import measured

OVERLAY = """channels:
  lan: {include: lan.yaml, round_trip_delay: null}
"""


def measurement(there: BadNetwork, back: BadNetwork, count: int = 4000) -> NetworkMeasurement:
    """What a probe at 128 Hz would bring home over such a network."""
    ways = Impairer(there, 1), Impairer(back, 2)
    period = 7_812_500
    times = np.zeros((4, count), dtype=np.int64)
    received = 0
    facts: list[tuple[int, int]] = []
    for number in range(count):
        sent = times[0, number] = 10**9 + number * period
        arrived = ways[0].take(b"p", sent)
        if not arrived:
            continue
        received += 1
        came = ways[1].take(b"p", arrived[0][0])
        if came:
            times[1:, number] = arrived[0][0], arrived[0][0], came[0][0]
            facts.append((number, received))
    return measured(128.0, times[0], times[3], times[1], times[2], counts=dict(facts))


def cohaptic(*words: str) -> str:
    result = CliRunner().invoke(cli, list(words), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    found = characterise(
        measurement(
            BadNetwork(delay=0.0060, jitter=0.0010, loss=0.02),
            BadNetwork(delay=0.0050, jitter=0.0005, loss=0.01),
        )
    )
    (tmp_path / "lan.yaml").write_text(channel_preset(found, name="there:47010"))
    (tmp_path / "measured.yaml").write_text(OVERLAY)
    return tmp_path


def test_the_preset_says_what_was_measured(folder: Path) -> None:
    channel = load("single_axis_distributed", (str(folder / "measured.yaml"),)).channels["lan"]
    tick = 1e3 / 1024
    for way, mean, jitter, loss in (
        (channel.forward, 5.5, 1.0, 0.02),
        (channel.backward, 5.5, 0.5, 0.01),
    ):
        found = average(way)
        # Times are rounded up to ticks of a millisecond.
        assert mean - 0.2 <= found.delay * tick <= mean + 1.5
        assert np.sqrt(found.variance) * tick == pytest.approx(jitter, abs=0.5)
        assert found.lost == pytest.approx(loss, abs=0.006)


def test_a_scenario_runs_over_the_measured_network_with_gains_designed_for_it(folder) -> None:
    measured = ("--with", str(folder / "measured.yaml"))
    gains = folder / "gains.yaml"
    scenario = "single_axis_distributed"
    words = ("theory", "design", "--scenario", scenario, *measured, "--out", str(gains), "--json")
    # Gains that are given leave less to search.
    words += ("--set", "k_11=2000", "--set", "k_o=50")
    designed = json.loads(cohaptic(*words))
    assert max(designed["corners"].values()) < 1.0
    words = ("run", scenario, *measured, "--with", str(gains), "--duration", "1 s", "--no-figure")
    summary = json.loads(cohaptic(*words, "--out", str(folder / "run"), "--json"))
    assert summary["status"] == 0
    channel = load(scenario, (str(folder / "measured.yaml"), str(gains))).components
    assert channel["coupler_12"].parameters["stiffness"] == pytest.approx(
        designed["gains"]["k_12"], rel=1e-3
    )


@pytest.mark.parametrize("scenario", ["single_axis_distributed", "two_users_box"])
def test_the_design_takes_delay_jitter_and_loss_from_the_scenarios_channel(
    folder, monkeypatch, scenario: str
) -> None:
    seen: list[Network] = []

    def design(parameters, network, *_, **__):
        seen.append(network)
        raise StopIteration

    monkeypatch.setattr("cosim.cli.theory.design.design", design)
    words = ["theory", "design", "--scenario", scenario, "--with", str(folder / "measured.yaml")]
    for more in ([], ["--jitter", "0.003"], ["--each-way-delay", "2"]):
        CliRunner().invoke(cli, [*words, *more])
    plain, jitter, samples = seen
    assert 5.3e-3 <= plain.delay <= 7.5e-3
    assert plain.jitter == pytest.approx(1.0e-3, abs=0.5e-3)
    assert plain.loss == pytest.approx(0.02, abs=0.006)
    assert (jitter.delay, jitter.jitter, jitter.loss) == (plain.delay, 0.003, plain.loss)
    assert (samples.delay, samples.jitter, samples.loss) == (2 / 128, plain.jitter, plain.loss)
