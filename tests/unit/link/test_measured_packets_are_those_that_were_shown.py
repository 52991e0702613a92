"""The trace of a session holds as many packets as its record shows, wherever the grids are.

Two clocks that drift apart let one station's ticks slide along the other's: a packet is then older
or younger than the difference of the ticks at which it was sampled and shown.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.base.recording import Column, MemorySink, RecordGroup
from cosim.link.stream.form import LinkForm
from cosim.link.stream.receiver import ReceiverSettings
from cosim.record.memory import run_in_memory
from cosim.record.reader import Run
from cosim.scenario import load
from cosim.station.measured import fates_of
from cosim.testing.impairment import BadNetwork
from tests.support.link.simulated import Network
from tests.support.link.support import PERIOD, make_pair
from tests.support.link.world import SimulatedStation, run
from tests.unit.link.test_session_in_simulated_time import SECOND, START, two

RATE, EVERY = 128, 4
CHANNEL = f"""cohaptic: 1
duration: 1 s
rates: {{control: {RATE} Hz, network: {RATE // EVERY} Hz}}
components:
  one: {{fmu: operator, rate: control, station: a}}
  other: {{fmu: operator, rate: control, station: b}}
channels: {{lan: {{between: [a, b], rate: network, each_way_delay: 1}}}}
"""


def recorded(rows: list[tuple[int, ...]]) -> Run:
    """A station's record of what its link said at each tick."""
    names = ("sequence", "delay", "sample")
    columns = tuple(Column(name=f"link_a.lan.{n}", unit=None, is_float=False) for n in names)
    sink = MemorySink(len(rows))
    sink.begin((RecordGroup(name="control", period=1, columns=columns),), RATE)
    sink.buffer(0, len(rows))[:] = np.array(rows)
    sink.commit(0, 0, len(rows))
    return run_in_memory(sink, {"link": {"peers": {"a": {"component": "link_a"}}}})


@pytest.mark.parametrize("skew", [-150e-6, 0.0, 150e-6])
def test_every_packet_that_was_shown_is_measured_and_no_other(skew: float, tmp_path: Path) -> None:
    network = Network()
    network.join("a", "b", BadNetwork(delay=0.002, jitter=0.0003, loss=0.05))
    a, b = two(network, skew, rate=RATE, period=EVERY, settings=LinkForm(clock="free"))
    rows: list[tuple[int, ...]] = []
    shown: list[int] = []

    def watch(station: SimulatedStation, tick: int) -> None:
        receiver = station.link.incoming[0].receiver
        rows.append(tuple(int(station.value(f"lan.{n}")) for n in ("sequence", "delay", "sample")))
        if station.link.incoming[0].fresh:
            shown.append(receiver.sequence)

    b.watch = watch
    run(network, [a, b], START + 180 * SECOND)
    assert abs(b.link.incoming[0].receiver.slip) >= (2 if skew else 0)
    file = tmp_path / "two.yaml"
    file.write_text(CHANNEL)
    fates = fates_of(recorded(rows), "a", load(file).channels["lan"])
    assert fates is not None
    assert np.count_nonzero(fates >= 0) == len(shown)
    # One packet a sample, and the first was sent at the first.
    lost = set(range(shown[0], shown[-1] + 1)) - set(shown)
    first = int(np.argmax(fates >= 0)) - shown[0]
    assert {number + first for number in lost} == {
        number for number in np.flatnonzero(fates < 0) if shown[0] <= number - first <= shown[-1]
    }


def test_a_new_session_whose_packet_has_the_same_sequence_is_another_packet(tmp_path: Path) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(CHANNEL)
    rows = [(-1, -1, -1)] * 4 + [(0, 4, 0)] * 4 + [(1, 4, 1)] * 4 + [(1, 4, 2)] * 4
    fates = fates_of(recorded(rows), "a", load(file).channels["lan"])
    assert fates is not None
    assert fates.tolist() == [4, 4, 4, -1]


def test_a_station_that_is_ahead_of_what_it_is_sent_is_no_simulation(tmp_path: Path) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(CHANNEL)
    rows = [(-1, -1, -1)] * 4 + [(0, 4, 0)] * 4 + [(1, 1, 3)] * 4
    assert fates_of(recorded(rows), "a", load(file).channels["lan"]) is None


@pytest.mark.parametrize("slip", [-9, -PERIOD, 0, 3, PERIOD])
def test_a_receiver_says_which_sample_it_shows(slip: int) -> None:
    pair = make_pair(ReceiverSettings(delay=2))
    pair.receiver.slip = slip
    assert pair.receiver.sample == -1
    for sample in range(1, 30):
        now = sample * PERIOD + slip + 1
        pair.receiver.accept(memoryview(pair.packet(sample * PERIOD)), now)
        pair.receiver.release(now + 2 * PERIOD)
        assert pair.receiver.sample == sample
