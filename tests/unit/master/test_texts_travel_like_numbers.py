"""Texts and binary values go over connections and channels exactly as numbers beside them do."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
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
