"""Texts and binary values go over connections and channels exactly as numbers beside them do."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError, RunError
from cosim.base.recording import MemorySink
from cosim.base.texts import TextTable
from cosim.master.assembly.assemble import put_together
from cosim.master.run.simulation import assemble
from cosim.master.run.snapshot import Snapshot
from cosim.station.split import split
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

PARTS = "tests.support.master.text_parts"
GOES = ["number", "word", "data", "names"]


def two(channel: Mapping[str, Any] | None = None, **more: Any) -> dict[str, Any]:
    """A counter at one station and a repeater at another, or both at one."""
    via: dict[str, Any] = {} if channel is None else {"via": "net"}
    stations = {"here": {}, "there": {}} if channel is not None else None
    where = ({"station": "here"}, {"station": "there"}) if channel is not None else ({}, {})
    written: dict[str, Any] = {
        "duration": 1,
        "components": {
            "one": {"python": f"{PARTS}:Counter", "rate": more.pop("rate", 64), **where[0]},
            "two": {"python": f"{PARTS}:Repeater", "rate": more.pop("other", 64), **where[1]},
        },
        "connections": [
            {"from": f"one.{name}", "to": f"two.{name}", **via, **more} for name in GOES
        ],
        "record": ["*"],
    }
    if channel is not None:
        written["channels"] = {"net": {"between": ["here", "there"], **channel}}
        del stations
    return written


def held(sink: MemorySink, name: str) -> dict[int, bytes]:
    """What a text was at each of its rows' ticks."""
    found: dict[int, bytes] = {}
    for number, group in enumerate(sink.groups):
        for index, column in enumerate(group.texts):
            if column.name == name:
                changes = sink.text(number, index)
                for tick in range(0, len(sink.rows(number)) * group.period, group.period):
                    found[tick] = [c for at, c in changes if at <= tick][-1]
    return found


def check_same(sink: MemorySink) -> int:
    """The texts beside a number are that number's; how many values it took."""
    for component in ("one", "two"):
        numbers = sink.signal(f"{component}.number").tolist()
        words = list(held(sink, f"{component}.word").values())
        data = list(held(sink, f"{component}.data").values())
        assert [f"n°{number}".encode() for number in numbers] == words
        assert [b"\0" + str(number).encode() for number in numbers] == data
    return len(set(sink.signal("two.number").tolist()))


@settings(max_examples=12, deadline=None)
@given(
    delay=st.sampled_from([0, 1, 2]),
    loss=st.sampled_from([0.0, 0.3]),
    jitter=st.booleans(),
    rates=st.sampled_from([(64, 64), (64, 16), (16, 64)]),
)
def test_a_text_in_a_packet_shares_its_fate(
    tmp_path_factory: pytest.TempPathFactory,
    delay: int,
    loss: float,
    jitter: bool,
    rates: tuple[int, int],
) -> None:
    folder = tmp_path_factory.mktemp("texts")
    channel: dict[str, Any] = {"rate": 32, "each_way_delay": delay, "loss": loss}
    if jitter:
        channel["jitter"] = "40 ms"
    sink, _ = run(scenario_of(folder, two(channel, rate=rates[0], other=rates[1])))
    assert check_same(sink) > 3


def test_a_plain_connection_samples_and_holds(tmp_path: Path) -> None:
    sink, _ = run(scenario_of(tmp_path, two(rate=16, other=64, delay="31.25 ms", initial="start")))
    assert check_same(sink) == 17
    heard = held(sink, "two.heard")
    assert heard[0] == b""
    assert heard[1] == heard[2] == b"n\xc2\xb0-1"


def test_an_array_of_texts_travels_whole(tmp_path: Path) -> None:
    sink, _ = run(scenario_of(tmp_path, two()))
    assert [held(sink, f"two.names[{i}]")[32] for i in (1, 2)] == [b"a32", b"b32"]
    assert held(sink, "two.seen")[32] == b"\x0031"


WRONG = [
    ("one.word", "two.data", r"one.word \(String\) cannot drive two.data \(Binary\)"),
    ("one.word", "two.number", r"cannot drive two.number \(Int64\)"),
    ("one.number", "two.word", r"cannot drive two.word \(String\)"),
    ("one.names", "two.word", "one.names has 2 elements and two.word one element"),
]


@pytest.mark.parametrize(("source", "target", "sentence"), WRONG)
def test_types_agree(tmp_path: Path, source: str, target: str, sentence: str) -> None:
    written = two() | {"connections": [{"from": source, "to": target}]}
    with pytest.raises(InputError, match=sentence) as caught:
        assemble(scenario_of(tmp_path, written))
    assert "test.yaml:" in str(caught.value)


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ({"factor": 2}, "only a real input takes a factor"),
        ({"unit": "ignore"}, "the units of both ends agree"),
    ],
)
def test_a_text_is_not_converted(tmp_path: Path, more: dict[str, Any], sentence: str) -> None:
    written = two() | {"connections": [{"from": "one.word", "to": "two.word", **more}]}
    with pytest.raises(InputError, match=sentence):
        assemble(scenario_of(tmp_path, written))


def fmu_pair(folder: Path, version: int, **more: Any) -> dict[str, Any]:
    """A counter whose word goes through an FMU that shows it a step later, to a repeater."""
    kinds = ["String"] if version == 2 else ["String", "Binary"]
    inside = {"String": "", "Binary": ""}
    variables = "\n".join(
        scalar(version, f"{kind}_{way}", reference, kind, inside[kind], causality=way, **start)
        for kind in kinds
        for way, reference, start in (
            ("input", 1 + 2 * kinds.index(kind), {"start": "zero"} if version == 2 else {}),
            ("output", 1 + 2 * kinds.index(kind), {}),
        )
    )
    outputs = [2, 4][: len(kinds)]
    structure = (
        "<Outputs>" + "".join(f'<Unknown index="{n}"/>' for n in outputs) + "</Outputs>"
        if version == 2
        else "".join(
            f'<Output valueReference="{1 + 2 * n}" dependencies=""/>' for n in range(len(kinds))
        )
    )
    fmu = foreign_fmu(folder, version, variables, structure=structure)
    return {
        "duration": 1,
        "components": {
            "one": {"python": f"{PARTS}:Counter", "rate": 64},
            "it": {"fmu": str(fmu), "rate": 64, **more},
            "two": {"python": f"{PARTS}:Repeater", "rate": 64},
        },
        "connections": [
            pair
            for kind, name in zip(kinds, ["word", "data"], strict=False)
            for pair in (
                {"from": f"one.{name}", "to": f"it.{kind}_input"},
                {"from": f"it.{kind}_output", "to": f"two.{name}"},
            )
        ],
        "record": ["*"],
    }


@pytest.mark.parametrize("isolated", [False, True])
@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_takes_and_gives_texts(tmp_path: Path, version: int, isolated: bool) -> None:
    more = {"isolate": "process"} if isolated else {}
    sink, _ = run(scenario_of(tmp_path, fmu_pair(tmp_path, version, **more)))
    through = list(held(sink, "two.word").values())
    said = list(held(sink, "one.word").values())
    assert through[2:] == said[1:-1]
    if version == 3:
        assert (
            list(held(sink, "two.data").values())[2:] == list(held(sink, "one.data").values())[1:-1]
        )
    assert np.array_equal(sink.signal("one.number"), range(64))


def test_a_real_link_refuses_a_text_by_name(tmp_path: Path) -> None:
    scenario = scenario_of(tmp_path, two({"rate": 32}))
    with pytest.raises(InputError, match=r"one\.word goes through the channel net and is a text"):
        split(put_together(scenario), "here")


def test_a_component_that_takes_no_texts_declares_none(tmp_path: Path) -> None:
    (tmp_path / "deaf.py").write_text(
        "from tests.support.master.text_parts import *\n"
        "class Deaf(Counter):\n    bind_texts = Component.bind_texts\n"
    )
    parts = {"it": {"python": "deaf.py:Deaf", "rate": 64}}
    with pytest.raises(InputError, match=r"the String 'word' is handed over by bind_texts"):
        assemble(scenario_of(tmp_path, {"duration": 1, "components": parts}))


@pytest.mark.parametrize("value", ["1", "b'x'", "'a\\0b'"])
def test_what_is_no_text_is_a_sentence(tmp_path: Path, value: str) -> None:
    (tmp_path / "wrong.py").write_text(
        "from tests.support.master.text_parts import *\nclass Wrong(Counter):\n"
        f"    def step(self, tick):\n        self.texts['word'][0] = {value}\n"
    )
    parts = {"it": {"python": "wrong.py:Wrong", "rate": 64}}
    with pytest.raises(RunError, match=r"it failed in step at tick 0.*String"):
        run(scenario_of(tmp_path, {"duration": 1, "components": parts}))


def test_what_nobody_names_any_more_is_forgotten() -> None:
    named: list[int] = []
    table = TextTable(lambda: named)
    for number in range(20000):
        named[:] = [table.number(b"%d" % number)]
    assert len(table.save()) == 2
    assert table.content(named[0]) == b"19999"


def test_what_is_named_has_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cosim.base.texts.MOST_LIVE_BYTES", 100)
    named: list[int] = []
    table = TextTable(lambda: named)
    named += [table.number(b"a" * 60), table.number(b"b" * 40)]
    with pytest.raises(ValueError, match="more than 100 bytes together"):
        table.number(b"c")


@pytest.mark.parametrize(
    "wrong",
    [{"unit": "m"}, {"minimum": 0}, {"start": 3}, {"start": ("a", "b", "c"), "shape": (2,)}],
)
def test_what_a_text_cannot_declare_is_refused(tmp_path: Path, wrong: dict[str, Any]) -> None:
    (tmp_path / "odd.py").write_text(
        "from tests.support.master.text_parts import *\nclass Odd(Counter):\n"
        f"    variables = [text('word', Causality.OUTPUT, **{wrong})]\n"
    )
    parts = {"it": {"python": "odd.py:Odd", "rate": 64}}
    with pytest.raises(InputError, match=r"'word'"):
        assemble(scenario_of(tmp_path, {"duration": 1, "components": parts}))


def test_a_snapshot_carries_what_flies_and_what_is_held(tmp_path: Path) -> None:
    """Restored into another simulation, also in mid-flight, the rest is the same."""
    scenario = scenario_of(tmp_path, two({"rate": 32, "each_way_delay": 2, "loss": 0.2}))
    whole, _ = run(scenario)
    with assemble(scenario) as simulation:
        simulation.start()
        simulation.advance(29)
        snapshot = Snapshot.from_bytes(simulation.snapshot().to_bytes())
    rest = Late()
    with assemble(scenario) as simulation:
        simulation.restore(snapshot)
        simulation.run(rest)
    for name in ("one.word", "two.word", "two.data", "two.heard", "two.names[2]"):
        columns = [column.name for column in whole.groups[0].texts]
        changes = rest.text(0, columns.index(name))
        now = {t: [c for at, c in changes if at <= t][-1] for t in range(29, 64)}
        assert now == {tick: value for tick, value in held(whole, name).items() if tick >= 29}


class Late(MemorySink):
    """Takes the rows of the rest of a run."""

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """Rows are not looked at."""
