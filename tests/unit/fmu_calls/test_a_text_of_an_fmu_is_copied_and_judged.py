"""Texts of an FMU: taken at once, bad ones told, statuses and deaths as everywhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError, RunError
from cosim.base.recording import MemorySink
from cosim.base.texts import MOST_BYTES
from cosim.master.run.simulation import Simulation, assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

SHOWING = """
    #define WITHOUT_OWN_TEXTS
    static const char *shown(Foreign *m, uint32_t r)
    {{
        {body}
    }}
"""


def one(folder: Path, snippet: str, version: int = 3, **more: Any) -> dict[str, Any]:
    """An FMU with a String output ``word``, recorded."""
    structure = (
        '<Output valueReference="1" dependencies=""/>'
        if version == 3
        else '<Outputs><Unknown index="1"/></Outputs>'
    )
    output = scalar(version, "word", 1, "String", causality="output")
    fmu = foreign_fmu(folder, version, output, snippet=snippet, structure=structure)
    part = {"fmu": str(fmu), "rate": 100, **more}
    return {"duration": 0.1, "components": {"it": part}, "record": ["*"]}


def words(sink: MemorySink) -> list[str]:
    return [content.decode() for _, content in sink.text(0, 0)]


def outcome(folder: Path, snippet: str, **more: Any) -> tuple[list[str], Simulation]:
    sink, simulation = run(scenario_of(folder, one(folder, snippet, **more)))
    return words(sink), simulation


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("more", [{}, {"isolate": "process"}])
def test_one_buffer_for_all_texts_is_enough(
    tmp_path: Path, version: int, more: dict[str, Any]
) -> None:
    """The FMU writes each text over the last one, as it may after the next call."""
    body = "static char room[2]; room[0] = (char)('a' + (int)(m->time * 100 + 0.5)); return room;"
    found, _ = outcome(tmp_path, SHOWING.format(body=body), version=version, **more)
    assert found == list("abcdefghi")


def test_no_text_at_all_is_an_empty_one_and_is_told(tmp_path: Path) -> None:
    found, simulation = outcome(tmp_path, SHOWING.format(body="return 0;"))
    assert found == [""]
    (said,) = simulation.outcome.said["it"]
    assert "it put out no String at all (NULL) as word" in str(said)


def test_what_is_not_utf_8_is_replaced_and_told(tmp_path: Path) -> None:
    found, simulation = outcome(tmp_path, SHOWING.format(body='return "B\\xf6x";'))
    assert found == ["B\ufffdx"]
    (said,) = simulation.outcome.said["it"]
    assert "a String that is not UTF-8 as word" in str(said)


HOOK = """
    static int hook(Foreign *m, const char *call)
    {{
        if (is(call, "GetString") && m->time > 0.045)
            {body}
        return 0;
    }}
    #define HOOK hook
"""


@pytest.mark.parametrize(
    ("status", "sentence"),
    [
        (3, "it returned status 'error' from reading its outputs at tick 6"),
        (4, "it returned status 'fatal' from reading its outputs at tick 6"),
    ],
)
def test_a_bad_status_ends_the_run_with_its_reason(
    tmp_path: Path, status: int, sentence: str
) -> None:
    body = f'{{ say(m, {status}, "no more words"); return {status}; }}'
    with pytest.raises(RunError, match=sentence) as caught:
        outcome(tmp_path, HOOK.format(body=body))
    assert "it said: no more words" in str(caught.value)


def test_a_warning_is_counted(tmp_path: Path) -> None:
    _, simulation = outcome(tmp_path, HOOK.format(body="return 1;"))
    assert simulation.outcome.warnings == {"it": 4}


def test_a_process_that_ends_in_it_is_named(tmp_path: Path) -> None:
    snippet = "void abort(void);" + HOOK.format(body="abort();")
    with pytest.raises(RunError, match=r"it crashed .SIGABRT: aborted. in fmi3GetString at tick 6"):
        outcome(tmp_path, snippet, isolate="process")


def test_a_text_that_is_too_long_is_refused(tmp_path: Path) -> None:
    body = f"""static char room[{MOST_BYTES + 2}];
        for (int i = 0; i <= {MOST_BYTES}; i++) room[i] = 'x';
        return room;"""
    with pytest.raises(RunError, match=f"it: .* {MOST_BYTES + 1} bytes is longer than"):
        outcome(tmp_path, SHOWING.format(body=body))


START = {"word": "a b", "data": "hex:00 ff"}


@pytest.mark.parametrize("section", ["parameters", "start"])
def test_parameters_and_start_values_reach_the_fmu(tmp_path: Path, section: str) -> None:
    """A store of values shows what was set: a String, a Binary and an array of Strings."""
    causality = "parameter" if section == "parameters" else "input"
    fixed = {"variability": "fixed"} if section == "parameters" else {}
    two = '<Dimension start="2"/><Start value="u"/><Start value="v"/>'
    variables = "\n".join(
        [
            scalar(3, "word", 1, "String", '<Start value="w"/>', causality=causality, **fixed),
            scalar(3, "data", 2, "Binary", '<Start value="01"/>', causality=causality, **fixed),
            scalar(3, "names", 7, "String", two, causality=causality, **fixed),
            scalar(3, "said", 1, "String", causality="output"),
            scalar(3, "seen", 2, "Binary", causality="output"),
        ]
    )
    structure = "".join(f'<Output valueReference="{n}" dependencies=""/>' for n in (1, 2))
    fmu = foreign_fmu(tmp_path, 3, variables, structure=structure)
    written = {
        "duration": 0.1,
        "components": {"it": {"fmu": str(fmu), "rate": 100, section: START}},
        "record": ["it.said", "it.seen"],
    }
    sink, simulation = run(scenario_of(tmp_path, written))
    assert [sink.text(0, n) for n in (0, 1)] == [[(0, b"a b")], [(0, b"\x00\xff")]]
    declared = simulation.assembly.participants["it"].interface.variables
    assert declared["names"].start == ("u", "v")
    assert declared["data"].start == b"\x01"


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ("00ff", "is binary data: write it as hex:48656c6c6f or base64:SGVsbG8="),
        (3, "is binary data: write it as"),
        ("hex:0", "'hex:0' is not hex"),
        ("base64:A", "'base64:A' is not base64"),
        ("hex:" + "00" * (MOST_BYTES + 1), "texts and binary data of up to"),
    ],
)
def test_a_binary_is_spelled(tmp_path: Path, value: Any, sentence: str) -> None:
    variable = scalar(3, "data", 1, "Binary", causality="input")
    fmu = foreign_fmu(tmp_path, 3, variable)
    part = {"fmu": str(fmu), "rate": 100, "start": {"data": value}}
    with pytest.raises(InputError, match=sentence) as caught:
        assemble(scenario_of(tmp_path, {"duration": 1, "components": {"it": part}}))
    assert "test.yaml:1:" in str(caught.value)
