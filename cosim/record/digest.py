"""Equality of runs: one hash over what was recorded, and nothing that depends on when or where."""

from __future__ import annotations

import hashlib
import struct
from typing import Any

import numpy as np

from cosim.record.reader import Run
from cosim.record.signals import SignalGroup


def digest(run: Run) -> str:
    """SHA-256 (hex) of a run's ticks, names, units and values.

    Two runs have one digest if and only if they have the same base rate and start, the same
    groups, and in each the same ticks and the same signals with the same units, types and values,
    bit for bit (-0.0 is not 0.0), and the same changes of texts. Groups and signals are taken in
    the order of their names. File layout, wall-clock times, descriptions and the manifest do not
    count. The bytes that are hashed are in docs/record.md.
    """
    state = hashlib.sha256(b"cohaptic run 1\n")
    _text(state, str(run.base_rate))
    if run.start_tick:
        _text(state, f"start {run.start_tick}")
    for name, group in sorted(run.groups.items()):
        _text(state, name)
        state.update(struct.pack("<qqq", group.period, group.rows, len(group.signals)))
        for first, last in group.pieces():
            state.update(np.ascontiguousarray(group.ticks_of(first, last), "<i8").data)
        for signal_name, signal in sorted(group.signals.items()):
            _text(state, signal_name)
            _text(state, signal.unit)
            _text(state, "float64" if signal.is_float else "int64")
            for block in signal.blocks():
                state.update(np.ascontiguousarray(block, "<f8" if signal.is_float else "<i8").data)
        if group.texts:
            _texts(state, group)
    return state.hexdigest()


def _texts(state: Any, group: SignalGroup) -> None:
    """A group without texts has what it had before there were any."""
    _text(state, "texts")
    state.update(struct.pack("<q", len(group.texts)))
    for name, text in sorted(group.texts.items()):
        _text(state, name)
        _text(state, "Binary" if text.column.is_binary else "String")
        state.update(struct.pack("<q", len(text.changes)))
        for tick, content in text.changes:
            state.update(struct.pack("<qq", tick, len(content)))
            state.update(content)


def _text(state: Any, text: str) -> None:
    encoded = text.encode()
    state.update(struct.pack("<q", len(encoded)))
    state.update(encoded)
