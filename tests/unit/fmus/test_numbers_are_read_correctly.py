"""Text becomes the nearest double, tables are read whole, and errors name file and line."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.support.fmus.native_support import library


def _parse(text: str, value: ctypes.c_double) -> int:
    return library().probe_parse(text.encode(), ctypes.byref(value))


def value_of(text: str) -> float:
    value = ctypes.c_double()
    assert _parse(text, value) == len(text), text
    return value.value


@settings(deadline=None, max_examples=150)
@given(st.floats(allow_nan=False, allow_infinity=False))
@example(5e-324)
@example(2.2250738585072011e-308)
@example(1.7976931348623157e308)
@example(-0.0)
def test_the_shortest_text_gives_the_number_back(number: float) -> None:
    assert np.float64(value_of(repr(number))).tobytes() == np.float64(number).tobytes()


@settings(deadline=None, max_examples=150)
@given(st.from_regex(r"[-+]?[0-9]{1,20}(\.[0-9]{0,20})?([eE][-+]?[0-9]{1,3})?", fullmatch=True))
@example("9007199254740993")  # halfway between two doubles: to even
@example("9007199254740993.00000000000000000001")  # just above halfway
@example("0.50000000000000016653345369377348106354")
@example("2.4703282292062327e-324")  # just below half of the least subnormal
@example("2.4703282292062328e-324")
@example("." + "0" * 30 + "1")
def test_any_decimal_is_rounded_to_nearest(text: str) -> None:
    expected = float(text)
    if np.isinf(expected):
        assert _parse(text, ctypes.c_double()) == 0
    else:
        assert np.float64(value_of(text)).tobytes() == np.float64(expected).tobytes()


@pytest.mark.parametrize("text", ["", "-", ".", "e5", "+.e1", "nan", "inf", "abc", "1e999"])
def test_what_is_no_finite_number_is_not_read(text: str) -> None:
    assert _parse(text, ctypes.c_double()) == 0


def read(path: Path, text: str | bytes, columns: int = 2, capacity: int = 100) -> np.ndarray | str:
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    rows = np.zeros((capacity, columns))
    count = ctypes.c_size_t()
    problem = library().probe_table(
        str(path).encode(), columns, capacity, rows.ctypes.data, ctypes.byref(count)
    )
    return rows[: count.value] if problem is None else problem.decode()


@pytest.mark.parametrize(
    "text",
    [
        "0,1\n2,3\n",
        "0 1\n2 3",
        "0;1\r\n2;3\r\n",
        "\n# comment\ntime, value\n0\t1\n\n  2 ,  3  \n",
        b"\xef\xbb\xbf0,1\n2,3\n",
        "0e0 1.0\n20e-1 0.3e+1",
    ],
)
def test_tables_come_in_many_shapes(tmp_path: Path, text: str | bytes) -> None:
    assert np.array_equal(read(tmp_path / "table.csv", text), [[0, 1], [2, 3]])


def test_a_long_file_is_read_whole(tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    table = random.normal(size=(3000, 2)) * 10.0 ** random.integers(-30, 30, (3000, 2))
    text = "\n".join(",".join(repr(float(x)) for x in row) for row in table)
    assert np.array_equal(read(tmp_path / "long.csv", text, capacity=3000), table)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["holds no numbers"]),
        ("# nothing\n", ["holds no numbers"]),
        ("1,2\n3\n", ["line 2", "1 numbers; 2 are needed"]),
        ("1,2\n3,4,5\n", ["line 2", "3 numbers; 2 are needed"]),
        ("1,2\nthree,4\n", ["line 2", "'three,4'"]),
        ("1,2\n3,nan\n", ["line 2", "'3,nan'"]),
        ("a,b\nc,d\n", ["line 2", "'c,d'"]),
        ("1,2\n" * 101, ["line 101", "more than 100 rows"]),
        ("1," + "2" * 600, ["line 1", "longer than 511"]),
    ],
)
def test_a_bad_table_is_refused_with_its_line(tmp_path: Path, text: str, words: list[str]) -> None:
    problem = read(tmp_path / "bad.csv", text)
    assert isinstance(problem, str)
    for word in ["bad.csv", *words]:
        assert word in problem


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "missing.csv", tmp_path):
        count = ctypes.c_size_t()
        rows = np.zeros(2)
        problem = library().probe_table(
            str(path).encode(), 1, 2, rows.ctypes.data, ctypes.byref(count)
        )
        assert str(path) in problem.decode()
        assert "cannot be" in problem.decode()
