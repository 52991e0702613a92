"""A comparison finds two runs equal exactly where their digests do, and says what is not."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

from cosim.base.recording import Column, RecordGroup, TextColumn
from cosim.cli.recorded import compare
from cosim.record import digest, open_run
from cosim.record.texts.recorded import RecordedText, write_texts
from cosim.report.comparison import compare_runs
from tests.support.record.synthetic_run import RATE, Cells, write

FORCE = Column(name="vr_a.force", unit="N", is_float=True)
STATE = Column(name="vr_a.state", unit=None, is_float=False)
HELD = Column(name="lan.held", unit="m", is_float=True)
WORD = RecordedText(TextColumn(name="vr_a.word", is_binary=False), ((0, b"a"), (40, b"b")))
FAST = RecordGroup(name="control", period=1, columns=(FORCE, STATE))
SLOW = RecordGroup(name="network", period=8, columns=(HELD,))


def _cells() -> tuple[Cells, ...]:
    random = np.random.default_rng(3)
    fast = np.stack([random.normal(size=96).view(np.int64), np.arange(96)], axis=1)
    return fast, random.normal(size=12).view(np.int64).reshape(-1, 1)


CELLS = _cells()


@dataclass(frozen=True)
class Recorded:
    """What is written; a field is what a case changes."""

    fast: RecordGroup = FAST
    slow: RecordGroup | None = SLOW
    cells: tuple[Cells, ...] = CELLS
    base_rate: Fraction = RATE
    start_tick: int = 0
    word: RecordedText | None = WORD

    def put(self, folder: Path) -> Path:
        groups = [group for group in (self.fast, self.slow) if group is not None]
        write(folder / "run.h5", groups, self.cells[: len(groups)], base_rate=self.base_rate)
        if self.start_tick:
            with h5py.File(folder / "run.h5", "r+") as file:
                file.attrs["start_tick"] = self.start_tick
        if self.word is not None:
            write_texts(folder / "texts.h5", {"control": [self.word]})
        return folder


SAME = Recorded()


def changed_cell(row: int, column: int, bit: int) -> tuple[Cells, ...]:
    fast, slow = (each.copy() for each in SAME.cells)
    fast[row, column] ^= np.int64(1) << bit
    return fast, slow


def word(*changes: tuple[int, bytes], is_binary: bool = False) -> RecordedText:
    return RecordedText(replace(WORD.column, is_binary=is_binary), changes)


def turned(recorded: Recorded) -> Recorded:
    """The same columns in another order, with other words about them."""
    fast, slow = recorded.cells
    columns = (STATE, replace(FORCE, description="what the finger feels"))
    return replace(
        recorded, fast=replace(recorded.fast, columns=columns), cells=(fast[:, ::-1], slow)
    )


def of_fast(**changes: Any) -> Recorded:
    return replace(SAME, fast=replace(SAME.fast, **changes))


NONE: tuple[str, ...] = ()
CASES: dict[str, tuple[Recorded, tuple[str, ...]]] = {
    "nothing": (SAME, NONE),
    "the order of columns": (turned(SAME), NONE),
    "the first bit of a value": (replace(SAME, cells=changed_cell(0, 0, 0)), ("vr_a.force",)),
    "the sign of a value": (replace(SAME, cells=changed_cell(95, 0, 62)), ("vr_a.force",)),
    "a whole number": (replace(SAME, cells=changed_cell(50, 1, 3)), ("vr_a.state",)),
    "the base rate": (replace(SAME, base_rate=Fraction(1000)), ("base rate: 1024 Hz → 1000 Hz",)),
    "the start": (replace(SAME, start_tick=512), ("start: tick 0 → tick 512",)),
    "a unit": (of_fast(columns=(replace(FORCE, unit="kN"), STATE)), ("vr_a.force: N → kN",)),
    "a type": (
        of_fast(columns=(FORCE, replace(STATE, is_float=True))),
        ("vr_a.state: int64 → float64",),
    ),
    "a name": (of_fast(columns=(replace(FORCE, name="vr_b.force"), STATE)), ("vr_b.force",)),
    "a group's name": (of_fast(name="fast"), ("fast.vr_a.force",)),
    "a group's rate": (of_fast(period=2), ("control: 1024 Hz → 512 Hz",)),
    "a group": (replace(SAME, slow=None), ("network.lan.held",)),
    "the number of rows": (
        replace(SAME, cells=(SAME.cells[0][:80], SAME.cells[1][:10])),
        ("96 ticks, and 80",),
    ),
    "rows of one group": (
        replace(SAME, cells=(SAME.cells[0], SAME.cells[1][:11]), slow=SAME.slow),
        ("96 ticks, and 88",),
    ),
    "rows that one group has beyond the others": (
        replace(SAME, cells=(np.concatenate([SAME.cells[0], SAME.cells[0][:4]]), SAME.cells[1])),
        ("control: 96 rows → 100 rows",),
    ),
    "rows behind the last whole tick": (
        replace(SAME, cells=(SAME.cells[0][:93], SAME.cells[1][:12])),
        ("96 ticks, and 93",),
    ),
    "a text": (replace(SAME, word=word((0, b"a"), (40, b"c"))), ("vr_a.word", "tick 40")),
    "when a text changed": (replace(SAME, word=word((0, b"a"), (41, b"b"))), ("tick 40",)),
    "when a text began": (replace(SAME, word=word((1, b"a"), (40, b"b"))), ("tick 0",)),
    "a text's type": (
        replace(SAME, word=word(*WORD.changes, is_binary=True)),
        ("vr_a.word: String → Binary",),
    ),
    "whether there is a text": (replace(SAME, word=None), ("control.vr_a.word",)),
}


def compared(folder: Path, name: str) -> tuple[bool, bool, str, Any]:
    """Whether digests and comparison say equal, the command's text and its JSON."""
    mine, theirs = SAME.put(folder / "one"), CASES[name][0].put(folder / "other")
    with open_run(mine) as one, open_run(theirs) as other:
        found = compare_runs(one, other)
        same = digest(one) == digest(other)
        json.dumps(asdict(found))
    call: Callable[..., Any] = CliRunner().invoke
    shown = call(compare.command, [str(mine), str(theirs)], catch_exceptions=False)
    told = call(compare.command, [str(mine), str(theirs), "--json"], catch_exceptions=False)
    assert shown.exit_code == told.exit_code == int(not found.are_equal)
    content = json.loads(told.stdout, parse_constant=lambda text: pytest.fail(f"{text} in JSON"))
    return same, found.are_equal, shown.stdout, content


@pytest.mark.parametrize("name", CASES)
def test_both_say_the_same(name: str, tmp_path: Path) -> None:
    same, are_equal, text, content = compared(tmp_path, name)
    assert are_equal == same == content["equal"] == (CASES[name][1] is NONE)
    for words in CASES[name][1]:
        assert words in text


@pytest.mark.parametrize("name", ["the base rate", "the start", "a group's rate", "a unit"])
def test_what_was_recorded_otherwise_is_not_compared_by_value(name: str, tmp_path: Path) -> None:
    """Tick 8 of one is another time in the other; 1 N is not less than 1 kN by 0."""
    first = np.int64(1)
    cells = (SAME.cells[0] ^ first, SAME.cells[1])
    other = replace(CASES[name][0], cells=cells)
    mine, theirs = SAME.put(tmp_path / "one"), other.put(tmp_path / "other")
    with open_run(mine) as one, open_run(theirs) as two:
        found = compare_runs(one, two)
    assert "vr_a.force" not in [each.name for each in found.signals]
    shown = CliRunner().invoke(compare.command, [str(mine), str(theirs)])
    assert shown.exit_code == 1
    assert "vr_a.force  since" not in shown.stdout
    if name in {"the base rate", "the start"}:
        assert found.signals == []
        assert "no value is compared" in shown.stdout
        assert "no value differs" not in shown.stdout


def test_runs_of_different_things_have_nothing_to_compare(tmp_path: Path) -> None:
    other = replace(SAME, fast=replace(FAST, name="f"), slow=replace(SLOW, name="s"), word=None)
    mine, theirs = replace(SAME, word=None).put(tmp_path / "one"), other.put(tmp_path / "other")
    shown = CliRunner().invoke(compare.command, [str(mine), str(theirs)])
    assert "no value is compared" in shown.stdout
    assert shown.exit_code == 1


def test_the_first_difference_has_its_time_from_zero(tmp_path: Path) -> None:
    late = replace(SAME, start_tick=1024)
    mine = late.put(tmp_path / "one")
    theirs = replace(late, cells=changed_cell(48, 0, 0)).put(tmp_path / "other")
    shown = CliRunner().invoke(compare.command, [str(mine), str(theirs)])
    assert "first vr_a.force at tick 48 (t = 1.04688 s)" in shown.stdout


def test_a_figure_is_of_numbers_and_missing_ones_are_told(tmp_path: Path) -> None:
    mine = SAME.put(tmp_path / "one")
    theirs = replace(SAME, word=word((0, b"c"))).put(tmp_path / "other")
    figure = tmp_path / "both.svg"
    shown = CliRunner().invoke(compare.command, [str(mine), str(theirs), "--figure", str(figure)])
    assert shown.exit_code == 1
    assert "nothing is drawn" in shown.stderr
    assert not figure.exists()


def test_a_figure_has_both_runs_over_one_another(tmp_path: Path) -> None:
    mine = SAME.put(tmp_path / "one")
    theirs = replace(SAME, cells=changed_cell(48, 0, 60)).put(tmp_path / "other")
    figure = tmp_path / "both.svg"
    CliRunner().invoke(compare.command, [str(mine), str(theirs), "--figure", str(figure)])
    drawn = figure.read_text()
    assert ">one<" in drawn.replace(" ", "")
    assert ">other<" in drawn.replace(" ", "")
