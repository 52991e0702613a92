"""What a model's ``State`` keeps from one step to the next, declared so that others can work on it.

The theory of a run perturbs a state's live numbers one by one; it has to know where in the saved
bytes they lie. A model lists what changes in its ``State`` by the C path of each member; the
offsets are the compiler's (``state_table``) and travel in the FMU, in ``extra/org.cohaptic``. What
is not listed is configuration: it never changes after initialisation.
"""

from __future__ import annotations

import ctypes
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

STATE_FILE = "extra/org.cohaptic/state.json"
"""Where in an FMU the table lies."""

CELLS_OFFSET = 80
"""Bytes of a saved state before its variables (``Snapshot`` in fmi/snapshot.c)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptReal:
    """A number with a unit.

    ``step`` (SI) is how far it may be moved so that differences are exact to about 1e-9. ``when``
    says at which parameters anything reads it: comparisons such as ``peers>=2`` or a switch's name,
    joined by ``&``; elsewhere it may change, but nothing depends on it.
    """

    path: str
    unit: str
    step: float = 1e-5
    when: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptWord:
    """A mode, count, tick or time: it must be the same however little the reals are moved.

    ``is_mode``: a run at rest keeps it as it is; counts, ticks and times go on.
    """

    path: str
    is_mode: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptRing:
    """Rows of numbers that are read by age: the row behind ``index`` is another one every tick.

    ``path`` is an array ``[rows][width]``. ``length`` is after how many rows the index begins
    anew, and ``live`` how many rows, counted from the index, are read; both are a number or a
    parameter's name. ``backwards``: older rows lie before the index.
    """

    path: str
    unit: str
    index: str
    rows: int
    width: int
    length: int | str
    live: int | str
    backwards: bool
    step: float = 1e-5
    when: str = ""


Kept = KeptReal | KeptWord | KeptRing


def reals(paths: Iterable[str], unit: str, *, step: float = 1e-5, when: str = "") -> list[Kept]:
    """Several numbers of one unit."""
    return [KeptReal(path=path, unit=unit, step=step, when=when) for path in paths]


def words(paths: Iterable[str], *, are_modes: bool = False) -> list[Kept]:
    """Several counts, ticks or times, or several modes."""
    return [KeptWord(path=path, is_mode=are_modes) for path in paths]


def offsets_source(model_source: Path, state: Iterable[Kept]) -> str:
    """C that exports the offset of every member; it takes the model's own file for the struct."""
    renamed = ("state_size", "state_used", "initialise", "retune", "outputs", "step")
    lines = [f"#define model_{name} unused_model_{name}" for name in renamed]
    lines += [f'#include "{model_source.as_posix()}"', ""]
    lines += [f"#undef model_{name}" for name in renamed]
    places = [f"    offsetof(struct State, {path})," for path in _members(state)]
    visible = '__attribute__((visibility("default")))'
    lines += [f"{visible} const uint64_t development_offsets[] = {{", *places, "    0", "};", ""]
    return "\n".join(lines)


def state_table(
    library: Path,
    state: tuple[Kept, ...],
    *,
    slots: int,
    digest: str,
    linear: bool,
) -> bytes:
    """The JSON that travels in the FMU; ``library`` was compiled with ``offsets_source``."""
    paths = _members(state)
    offsets = (ctypes.c_uint64 * len(paths)).in_dll(
        ctypes.CDLL(str(library)), "development_offsets"
    )
    place = dict(zip(paths, map(int, offsets), strict=True))
    table: dict[str, Any] = {
        "digest": digest[:32],
        "cells_offset": CELLS_OFFSET,
        "slots": slots,
        "linear": linear,
        "reals": [
            [kept.path, place[kept.path], kept.unit, kept.step, kept.when]
            for kept in state
            if isinstance(kept, KeptReal)
        ],
        "words": [
            [kept.path, place[kept.path], kept.is_mode]
            for kept in state
            if isinstance(kept, KeptWord)
        ],
        "rings": [
            {
                "path": kept.path,
                "offset": place[kept.path],
                "index": place[kept.index],
                "unit": kept.unit,
                "step": kept.step,
                "rows": kept.rows,
                "width": kept.width,
                "length": kept.length,
                "live": kept.live,
                "backwards": kept.backwards,
                "when": kept.when,
            }
            for kept in state
            if isinstance(kept, KeptRing)
        ],
    }
    return json.dumps(table, separators=(",", ":")).encode()


def _members(state: Iterable[Kept]) -> list[str]:
    """Every C path that an offset is wanted of, once."""
    found: dict[str, None] = {}
    for kept in state:
        found[kept.path] = None
        if isinstance(kept, KeptRing):
            found[kept.index] = None
    return list(found)
