"""Texts of a paced run reach its recorder as they are; a slow recorder still gets the newest."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.recording import MemorySink
from cosim.live.tee import TeeSink
from cosim.master.run.simulation import assemble
from cosim.realtime.paced_loop import paced
from cosim.realtime.pacing import DeadlinePacer
from cosim.realtime.relay import RelayPump, RelaySink, make_rings, make_text_ring
from cosim.realtime.shared.text_ring import TextRing
from cosim.scenario import Scenario
from tests.support.master.master_support import run, scenario_of

PARTS = "tests.support.master.text_parts"

actions = st.lists(
    st.one_of(st.none(), st.tuples(st.integers(0, 2), st.binary(max_size=40)), st.just("longest")),
    max_size=60,
)


@settings(deadline=None, max_examples=150)
@given(actions)
def test_the_newest_of_each_text_arrives_and_what_was_skipped_is_counted(
    actions: list[Any],
) -> None:
    """``None`` is a look of the reader; a frame has 24 bytes beside its content."""
    ring = TextRing.create(capacity=128)
    try:
        put: list[tuple[int, int, int, bytes]] = []
        got: list[tuple[int, int, int, bytes]] = []
        for tick, action in enumerate(actions):
            if action is None:
                ring.flush()
                got += ring.read()
                continue
            column, content = (0, bytes(500)) if action == "longest" else action
            put.append((0, column, tick, content))
            ring.put(*put[-1])
        got += ring.read()
        got += ring.rest()
        for column in range(3):
            sent = [each for each in put if each[1] == column]
            came = [each for each in got if each[1] == column]
            assert came == [each for each in sent if each in came], "in order, whole, once"
            assert came[-1:] == sent[-1:]
        assert len(got) + ring.skipped == len(put)
    finally:
        ring.remove()


class FakeTime:
    """Time that passes when somebody sleeps."""

    now = 0

    def __call__(self) -> int:
        return self.now

    def sleep(self, until: int) -> None:
        self.now = max(self.now, until)


def talkative(folder: Path, *record: str) -> Scenario:
    """A counter with texts and who repeats them, some recorded at another rate as well."""
    return scenario_of(
        folder,
        {
            "duration": 1,
            "components": {
                "one": {"python": f"{PARTS}:Counter", "rate": 64},
                "two": {"python": f"{PARTS}:Repeater", "rate": 16},
            },
            "connections": [
                {"from": f"one.{name}", "to": f"two.{name}"} for name in ("word", "data", "names")
            ],
            "record": list(record) or ["*"],
        },
    )


def in_a_paced_loop(scenario: Scenario, every: int) -> MemorySink:
    """What the recorder's side has of a paced run whose pump looks every so many ticks."""
    kept, simulation = MemorySink(), assemble(scenario)
    groups = simulation.groups
    with ExitStack() as stack:
        rings = make_rings(groups, scenario.base_rate)
        for ring in rings:
            stack.callback(ring.remove)
        texts = make_text_ring(groups)
        assert texts is not None
        stack.callback(texts.remove)
        kept.begin(groups, scenario.base_rate)
        pump = RelayPump(rings, groups, kept, texts)
        fake = FakeTime()

        def sleep(until: int) -> None:
            fake.sleep(until)
            if simulation.program.kernel.tick % every == 0:
                pump.pump()

        pacer = DeadlinePacer(tick_seconds=Fraction(1, 64), clock=fake, sleep=sleep)
        simulation.run(RelaySink(rings, groups, texts), drive=paced(pacer))
        assert pump.pump() == scenario.ticks
        for change in texts.rest():
            kept.put_text(*change)
        assert (pump.lost, pump.skipped) == (0, 0)
    return kept


def changes(sink: MemorySink) -> Iterator[tuple[str, str, list[tuple[int, bytes]]]]:
    for number, group in enumerate(sink.groups):
        for place, column in enumerate(group.texts):
            yield group.name, column.name, sink.text(number, place)


@pytest.mark.parametrize("record", [(), ("one.word",), ("two.heard", "one.number")])
@pytest.mark.parametrize("every", [1, 1000])
def test_a_paced_run_records_the_same_texts(
    tmp_path: Path, record: tuple[str, ...], every: int
) -> None:
    """Also where a group has nothing but texts."""
    scenario = talkative(tmp_path, *record)
    expected, _ = run(scenario)
    kept = in_a_paced_loop(scenario, every)
    assert list(changes(kept)) == list(changes(expected))
    assert any(len(found) > 10 for _, _, found in changes(kept))
    for number in range(len(expected.groups)):
        assert kept.rows(number).tolist() == expected.rows(number).tolist()


def test_who_watches_a_run_of_texts_alone_is_told_its_rows(tmp_path: Path) -> None:
    scenario = talkative(tmp_path, "one.word")
    with assemble(scenario) as simulation:
        rings = make_rings(simulation.groups, scenario.base_rate)
        kept = MemorySink()
        simulation.run(TeeSink(kept, rings))
        assert rings[0].written == scenario.ticks
        assert len(kept.text(0, 0)) == 64
        for ring in rings:
            ring.remove()
