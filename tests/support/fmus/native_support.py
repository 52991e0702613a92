"""The C below the FMI functions as a library for ctypes."""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path
from typing import Any

from fmus.builder import FOLDER, support_files
from fmus.compiler import compile_library, host_platform
from tests.support.scratch import scratch_folder

SOURCE = Path(__file__).parent / "native" / "probe.c"
INCLUDE = [FOLDER / "fmi", FOLDER / "libm", FOLDER / "libm" / "musl"]
UNARY = (
    *("sin", "cos", "tan", "asin", "acos", "atan", "tanh", "exp"),
    *("expm1", "log", "floor", "ceil", "round", "trunc", "sqrt", "fabs"),
)
BINARY = ("atan2", "pow", "fmod", "hypot", "fmin", "fmax", "copysign")


@functools.cache
def library() -> Any:
    path = scratch_folder("test") / f"probe{host_platform().suffix}"
    compile_library(host_platform(), path, [SOURCE, *support_files()], include=INCLUDE)
    loaded = ctypes.CDLL(str(path))
    loaded.probe_parse.argtypes = (ctypes.c_char_p, ctypes.POINTER(ctypes.c_double))
    loaded.probe_format.argtypes = (ctypes.c_char_p, ctypes.c_int, ctypes.c_double)
    loaded.probe_format.restype = ctypes.c_char_p
    loaded.probe_table.argtypes = (
        ctypes.c_char_p,
        ctypes.c_size_t,
        ctypes.c_size_t,
        ctypes.c_void_p,
        ctypes.POINTER(ctypes.c_size_t),
    )
    loaded.probe_table.restype = ctypes.c_char_p
    loaded.probe_unary.argtypes = (ctypes.c_int, ctypes.c_double)
    loaded.probe_unary.restype = ctypes.c_double
    loaded.probe_binary.argtypes = (ctypes.c_int, ctypes.c_double, ctypes.c_double)
    loaded.probe_binary.restype = ctypes.c_double
    loaded.probe_hash.restype = ctypes.c_uint64
    return loaded


def unary(name: str, x: float) -> float:
    return library().probe_unary(UNARY.index(name), x)


def binary(name: str, x: float, y: float) -> float:
    return library().probe_binary(BINARY.index(name), x, y)
