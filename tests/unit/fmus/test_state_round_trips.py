"""Saving, restoring and serialising the state gives back the same bits, at any point of a run."""

from __future__ import annotations

import ctypes
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.builder import load_model
from tests.support.fmus import fmu_support as support

STEPPING = [name for name in (*support.MODELS, *support.PROBES) if name != "probe_failure"]


def excite(fmu: support.Fmu, seed: int) -> None:
    """Set every input to something plausible that depends on the seed and its name only."""
    for name in fmu.names("input"):
        random = np.random.default_rng([seed, zlib.crc32(name.encode())])
        kind, variable = fmu.kind(name), fmu.variables[name]
        count = fmu.shape(name)
        if kind in {"Real", "Float64"}:
            values: list[Any] = list(fmu_start(variable, count) + random.normal(0, 1e-3, count))
        elif kind == "Boolean":
            values = [bool(v) for v in random.integers(0, 2, count)]
        elif kind in {"Int32", "Integer"} and variable.declaredType is None:
            values = [int(v) for v in random.integers(0, 3, count)]
        else:
            continue
        fmu.set(name, values if variable.shape else values[0])


def fmu_start(variable: Any, count: int) -> np.ndarray:
    return np.resize(np.array(str(variable.start).split(), float), count)


def save(fmu: support.Fmu) -> ctypes.c_void_p:
    state = ctypes.c_void_p()
    fmu.call("GetFMUstate" if fmu.fmi2 else "GetFMUState", ctypes.byref(state))
    return state


def restore(fmu: support.Fmu, state: ctypes.c_void_p) -> None:
    fmu.call("SetFMUstate" if fmu.fmi2 else "SetFMUState", state)


def serialise(fmu: support.Fmu, state: ctypes.c_void_p) -> bytes:
    size = ctypes.c_size_t()
    suffix = "FMUstate" if fmu.fmi2 else "FMUState"
    fmu.call(f"Serialized{suffix}Size", state, ctypes.byref(size))
    data = (ctypes.c_byte * size.value)()
    fmu.call(f"Serialize{suffix}", state, data, size)
    return bytes(data)


def deserialise(fmu: support.Fmu, data: bytes) -> ctypes.c_void_p:
    state = ctypes.c_void_p()
    name = "DeSerializeFMUstate" if fmu.fmi2 else "DeserializeFMUState"
    fmu.call(name, data, ctypes.c_size_t(len(data)), ctypes.byref(state))
    return state


def free(fmu: support.Fmu, state: ctypes.c_void_p) -> None:
    fmu.call("FreeFMUstate" if fmu.fmi2 else "FreeFMUState", ctypes.byref(state))
    assert state.value is None


def advance(fmu: support.Fmu, seeds: list[int]) -> list[bytes]:
    seen = []
    for seed in seeds:
        excite(fmu, seed)
        fmu.step(support.step_of(fmu.description.modelName))
        seen.append(fmu.bits())
    return seen


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
@pytest.mark.parametrize("name", STEPPING)
@settings(deadline=None, max_examples=3)
@given(
    before=st.lists(st.integers(0, 999), max_size=6),
    after=st.lists(st.integers(0, 999), min_size=1, max_size=6),
    detour=st.lists(st.integers(0, 999), max_size=4),
)
def test_any_point_of_any_run(
    name: str, flavour: str, before: list[int], after: list[int], detour: list[int]
) -> None:
    with support.Fmu(name, flavour) as fmu, support.Fmu(name, flavour) as other:
        fmu.start()
        advance(fmu, before)
        state, time, bits = save(fmu), fmu.time, fmu.bits()
        data = serialise(fmu, state)
        expected = advance(fmu, after)

        restore(fmu, state)  # back in the same instance
        fmu.time = time
        assert fmu.bits() == bits
        again = save(fmu)
        assert serialise(fmu, again) == data
        free(fmu, again)
        advance(fmu, detour)
        restore(fmu, state)
        fmu.time = time
        assert advance(fmu, after) == expected
        free(fmu, state)

        foreign = deserialise(other, data)  # into one that never ran
        restore(other, foreign)
        other.time = time
        assert serialise(other, foreign) == data
        assert other.bits() == bits
        assert advance(other, after) == expected
        free(other, foreign)


@pytest.mark.parametrize("name", STEPPING)
def test_outputs_are_pure(name: str) -> None:
    """Reading twice, in reverse, or not at all changes nothing."""
    with support.Fmu(name) as often, support.Fmu(name) as never:
        often.start()
        never.start()
        for seed in range(5):
            for fmu in (often, never):
                excite(fmu, seed)
            first = often.bits()
            names = often.names("output")
            backwards = {output: often.get(output) for output in reversed(names)}
            assert list(backwards) == names[::-1]
            assert often.bits() == first
            often.step(support.step_of(name))
            never.step(support.step_of(name))
        assert often.bits() == never.bits()


def test_a_state_of_another_model_is_refused() -> None:
    with support.Fmu("hand") as hand, support.Fmu("object") as other:
        hand.start()
        other.start()
        state = save(hand)
        with pytest.raises(support.Refused):
            restore(other, state)
        assert "not one of this build of 'object'" in other.log[-1][2]
        data = serialise(hand, state)
        with pytest.raises(support.Refused):
            deserialise(other, data.ljust(4096, b"\0"))
        free(hand, state)


@settings(deadline=None, max_examples=30)
@given(place=st.integers(0, 10_000), bit=st.integers(0, 7))
def test_damaged_bytes_are_refused(place: int, bit: int) -> None:
    with support.Fmu("hand") as fmu:
        fmu.start()
        state = save(fmu)
        data = bytearray(serialise(fmu, state))
        data[place % len(data)] ^= 1 << bit
        with pytest.raises(support.Refused):
            deserialise(fmu, bytes(data))
        free(fmu, state)


def test_cut_off_bytes_are_refused() -> None:
    with support.Fmu("hand") as fmu:
        fmu.start()
        state = save(fmu)
        data = serialise(fmu, state)
        for size in (0, 7, len(data) - 1):
            with pytest.raises(support.Refused):
                deserialise(fmu, data[:size])
        free(fmu, state)


def table(folder: Path, name: str, rows: int, height: float, columns: int = 2) -> str:
    """A file of ``rows`` rows a hundredth of a second apart, every value ``height``."""
    file = folder / name
    values = f", {height}" * (columns - 1)
    file.write_text("".join(f"{0.01 * k:.2f}{values}\n" for k in range(rows)))
    return str(file)


def table_signal(fmu: support.Fmu, file: str, stop_time: float = 100.0) -> None:
    fmu.set("mode", 4)
    fmu.set("table_file", file)
    fmu.start(stop_time=stop_time)


READERS = {
    "signal": ("mode", 4, "table_file", 2),
    "operator": ("trajectory", 3, "trajectory_file", 3),
}
"""Models with a table: what has them read it, the number for that, the file, and its columns."""


def test_every_model_with_a_table_is_looked_at() -> None:
    assert {n for n in support.MODELS if load_model(n).state_ends_in_table} == set(READERS)


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
@pytest.mark.parametrize("name", READERS)
def test_a_state_has_the_rows_of_its_table_and_no_room_for_more(
    name: str, flavour: str, tmp_path: Path
) -> None:
    """Of none where no table is read, of as many as its file has where one is."""
    choice, number, file, columns = READERS[name]
    sizes = []
    for rows in (0, 1, 101):
        with support.Fmu(name, flavour) as fmu:
            if rows:
                fmu.set(choice, number)
                fmu.set(file, table(tmp_path, "t.csv", rows, 1.0, columns))
            fmu.start(stop_time=100.0)
            state = save(fmu)
            sizes.append(len(serialise(fmu, state)))
            free(fmu, state)
    row = columns * 8
    assert (sizes[1] - sizes[0], sizes[2] - sizes[1]) == (row, 100 * row)
    assert sizes[0] < 10_000


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_a_state_brings_its_table_along(flavour: str, tmp_path: Path) -> None:
    """Also into an instance that has read another one, longer or shorter."""
    with support.Fmu("signal", flavour) as fmu:
        table_signal(fmu, table(tmp_path, "own.csv", 20, 2.0))
        state = save(fmu)
        data = serialise(fmu, state)
        free(fmu, state)
        for rows in (3, 50):
            with support.Fmu("signal", flavour) as other:
                table_signal(other, table(tmp_path, "other.csv", rows, 5.0))
                assert other.get("value") == 5.0
                foreign = deserialise(other, data)
                restore(other, foreign)
                assert other.get("value") == 2.0
                again = save(other)
                assert serialise(other, again) == data
                free(other, again)
                free(other, foreign)


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_the_stop_time_is_the_instances_own(flavour: str) -> None:
    """A short run's state goes on in a longer run, and a long run's ends with the shorter."""
    with support.Fmu("hand", flavour) as short, support.Fmu("hand", flavour) as long:
        short.start(stop_time=2 * support.STEP)
        long.start(stop_time=3 * support.STEP)
        advance(short, [1, 2])
        with pytest.raises(support.Refused):
            short.step(support.STEP)
        with support.Fmu("hand", flavour) as fresh:
            fresh.start(stop_time=2 * support.STEP)
            advance(fresh, [1, 2])
            state = save(fresh)
            data = serialise(fresh, state)
            free(fresh, state)
        foreign = deserialise(long, data)
        restore(long, foreign)
        long.time = 2 * support.STEP
        long.step(support.STEP)
        with pytest.raises(support.Refused):
            long.step(support.STEP)
        assert "stop time" in long.log[-1][2]
        free(long, foreign)
