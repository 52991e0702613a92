"""A Python component takes an FMU's place, and the numbers are the same; a paced run's too."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from cosim.realtime.paced_loop import paced
from cosim.realtime.pacing import DeadlinePacer
from tests.support.master.master_support import run, scenario_of
from tests.support.master.single_axis import GAINS, single_axis


def test_a_coupler_in_python_gives_the_bits_of_the_fmu(tmp_path: Path) -> None:
    gains, channel = GAINS["distributed"]["soft"], {"round_trip_delay": 1, "loss": 0.1}
    expected, _ = run(single_axis(tmp_path, "distributed", gains, channel), until=200)
    more = {
        "components": {
            name: {
                "python": "tests.support.master.master_parts:Spring",
                "parameters": {"stiffness": gains[gain], "damping": 10.0},
            }
            for name, gain in (("coupler_11", "k_own"), ("coupler_o2", "k_o"))
        }
    }
    scenario = single_axis(tmp_path, "distributed", gains, channel, more=more)
    actual, _ = run(scenario, until=200)
    for name in ("hand_1.position", "object_2.velocity", "coupler_11.force", "coupler_o2.reaction"):
        np.testing.assert_array_equal(actual.signal(name), expected.signal(name))


def test_its_seed_follows_from_its_name_alone(tmp_path: Path) -> None:
    part = {"python": "tests.support.master.master_parts:Growing", "rate": 1024}
    seeds = []
    for names in (("x", "y"), ("y", "x", "z")):
        written = {"duration": 0.01, "seed": 5, "components": dict.fromkeys(names, part)}
        _, simulation = run(scenario_of(tmp_path, written))
        component = simulation.assembly.participants["x"].component
        seeds.append(component.setup.seed)  # type: ignore[union-attr]
    assert seeds[0] == seeds[1]


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        ("tests.support.master.master_parts:Sprin", "Did you mean Spring?"),
        ("no_such_module:Spring", "cannot be imported"),
        ("tests.support.master.master_parts:Setup", "not a subclass"),
    ],
)
def test_a_class_that_cannot_be_used(tmp_path: Path, source: str, sentence: str) -> None:
    written = {"duration": 0.01, "components": {"mine": {"python": source, "rate": 1024}}}
    with pytest.raises(InputError, match=sentence.replace("?", r"\?")):
        assemble(scenario_of(tmp_path, written))


class FakeTime:
    """A clock that sleeping moves, and that work moves by what ``late`` says."""

    def __init__(self) -> None:
        self.now = 0
        self.slept: list[float] = []

    def __call__(self) -> int:
        return self.now

    def sleep(self, until: int) -> None:
        self.now = max(self.now, until)


def test_a_paced_run_gives_the_same_numbers(tmp_path: Path) -> None:
    scenario = single_axis(tmp_path, "distributed", GAINS["distributed"]["soft"], {"loss": 0.1})
    expected, _ = run(scenario, until=100)
    fake, sink = FakeTime(), MemorySink()
    pacer = DeadlinePacer(tick_seconds=Fraction(1, 1024), clock=fake, sleep=fake.sleep)
    outcome = assemble(scenario).run(sink, until=100, drive=paced(pacer))
    assert outcome.ticks == 100
    assert abs(fake.now * 1e-9 - 99 / 1024) < 2e-9
    np.testing.assert_array_equal(
        sink.signal("hand_1.position"), expected.signal("hand_1.position")
    )


def test_a_paced_run_is_turned_by_events_and_by_hand_at_the_same_ticks(tmp_path: Path) -> None:
    """By hand from within a tick, as another thread would: it acts from the next one on."""
    turned = {
        "knobs": {"lan.delay": {"maximum": 4}, "coupler_11.damping": {}},
        "events": [{"at": "40 ticks", "set": {"lan.forward.delay": 0, "coupler_11.stiffness": 9}}],
    }
    gains = GAINS["distributed"]["soft"]
    scenario = single_axis(tmp_path, "distributed", gains, {"loss": 0.1}, more=turned)
    fake, sink = FakeTime(), MemorySink()
    simulation = assemble(scenario)

    def sleep(until: int) -> None:
        fake.sleep(until)
        if simulation.program.kernel.tick == 60:
            simulation.set({"lan.backward.delay": 3, "coupler_11.damping": 0.5})

    pacer = DeadlinePacer(tick_seconds=Fraction(1, 1024), clock=fake, sleep=sleep)
    simulation.run(sink, until=100, drive=paced(pacer))
    assert [turn.tick for turn in simulation.program.turning.by_hand] == [60, 60]
    again, _ = run(simulation.replay(), until=100)
    plain, _ = run(scenario, until=100)
    for name in ("hand_1.position", "hand_2.position", "lan.backward.age", "lan.backward.delay"):
        np.testing.assert_array_equal(sink.signal(name), again.signal(name))
    assert (again.signal("lan.backward.age") != plain.signal("lan.backward.age")).any()
