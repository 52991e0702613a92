"""The bundled libm: right to within an ulp, and the same bits on every platform."""

from __future__ import annotations

import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.builder import support_files
from fmus.cache import cache_directory
from fmus.compiler import FLAGS, compiler_path
from tests.support.fmus.native_support import BINARY, INCLUDE, SOURCE, UNARY, binary, library, unary

GOLDEN = (
    (Path(__file__).parents[2] / "support" / "fmus" / "native" / "golden.txt").read_text().split()
)
"""Hash of each function, UNARY then BINARY; the same on x86-64 and arm64, gcc and clang."""

FINITE = st.floats(-1e15, 1e15)


def test_every_function_gives_the_recorded_bits() -> None:
    hashes = [f"{library().probe_hash(i):016x}" for i in range(len(UNARY) + len(BINARY))]
    names = [*UNARY, *BINARY]
    assert dict(zip(names, hashes, strict=True)) == dict(zip(names, GOLDEN, strict=True))


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("qemu-aarch64") is None, reason="needs qemu-user")
def test_arm64_gives_the_same_bits(tmp_path: Path) -> None:
    program = tmp_path / "probe"
    command = [str(compiler_path()), "cc", "-target", "aarch64-linux-gnu.2.17", *FLAGS]
    command += ["-DPROBE_STANDALONE", "-Wno-missing-prototypes", "-static", "-nostdlib"]
    command += [f"-I{folder}" for folder in INCLUDE]
    command += [str(path) for path in (SOURCE, *support_files())]
    cache = str(cache_directory() / "zig")
    environment = {"ZIG_GLOBAL_CACHE_DIR": cache, "ZIG_LOCAL_CACHE_DIR": cache}
    subprocess.run([*command, "-o", str(program)], check=True, env=environment)
    run = subprocess.run(["qemu-aarch64", str(program)], capture_output=True, check=True, text=True)
    assert run.stdout.split() == GOLDEN


@pytest.mark.parametrize("name", ["sin", "cos", "tan", "atan", "tanh", "exp", "expm1"])
@settings(deadline=None)
@given(x=st.floats(-700, 700))
def test_functions_of_one_number(name: str, x: float) -> None:
    expected = getattr(math, name)(x)
    assert abs(unary(name, x) - expected) <= 2 * math.ulp(expected)


@settings(deadline=None)
@given(x=st.floats(-1, 1), y=st.floats(1e-300, 1e300))
def test_functions_with_a_domain(x: float, y: float) -> None:
    for name, argument in (("asin", x), ("acos", x), ("log", y)):
        expected = getattr(math, name)(argument)
        assert abs(unary(name, argument) - expected) <= 2 * math.ulp(expected)
    assert unary("sqrt", y) == math.sqrt(y)
    assert math.isnan(unary("log", -y))
    assert math.isnan(unary("asin", 1.0 + max(y, 1e-9)))


@settings(deadline=None)
@given(x=FINITE, y=FINITE)
def test_rounding_and_comparing_are_exact(x: float, y: float) -> None:
    half_away = math.copysign(math.floor(abs(x) + 0.5), x) if abs(x) < 2**51 else x
    if abs(x) % 1 != 0.49999999999999994:
        assert unary("round", x) == half_away
    for name in ("floor", "ceil", "trunc"):
        assert unary(name, x) == getattr(np, name)(x)
    assert binary("fmin", x, y) == min(x, y)
    assert binary("fmax", x, y) == max(x, y)
    assert binary("copysign", x, y) == math.copysign(x, y)
    assert unary("fabs", x) == abs(x)
    if y != 0:
        assert binary("fmod", x, y) == math.fmod(x, y)


@settings(deadline=None)
@given(x=FINITE, y=FINITE, exponent=st.floats(-20, 20))
def test_functions_of_two_numbers(x: float, y: float, exponent: float) -> None:
    assert abs(binary("atan2", x, y) - math.atan2(x, y)) <= 2 * math.ulp(math.atan2(x, y))
    assert abs(binary("hypot", x, y) - math.hypot(x, y)) <= math.ulp(math.hypot(x, y))
    base = abs(x) + 1e-3
    if abs(exponent * math.log(base)) < 700:
        expected = math.pow(base, exponent)
        assert abs(binary("pow", base, exponent) - expected) <= math.ulp(expected)


def test_a_nan_loses_a_comparison() -> None:
    for name in ("fmin", "fmax"):
        assert binary(name, math.nan, 2.0) == 2.0
        assert binary(name, 2.0, math.nan) == 2.0
        assert math.isnan(binary(name, math.nan, math.nan))
