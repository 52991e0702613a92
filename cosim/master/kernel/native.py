"""The compiled kernel: finding it, and the types of its functions (``sources/kernel.h``)."""

from __future__ import annotations

import ctypes
from ctypes import c_int32, c_int64, c_void_p
from functools import cache
from typing import Any

from cosim.base.errors import RunError
from cosim.master.kernel.fmu_structures import LogStruct

ABI = 13


@cache
def library() -> Any:
    """The kernel for this machine.

    Raises:
        RunError: it was not built, or it is another version's.
    """
    from cosim.master.kernel.build import find_kernel
    from fmus.compiler import BuildError

    try:
        kernel = ctypes.CDLL(str(find_kernel()))
    except (BuildError, OSError) as error:
        raise RunError(f"the compiled kernel cannot be loaded: {error}; run 'uv sync'") from None
    kernel.kernel_abi.restype = c_int64
    if kernel.kernel_abi() != ABI:
        raise RunError("the compiled kernel is older than its sources; run 'uv sync'")
    kernel.kernel_run.argtypes = (c_void_p, c_int64)
    kernel.kernel_run.restype = c_int32
    kernel.kernel_evaluate.argtypes = (c_void_p, c_int64)
    kernel.kernel_evaluate.restype = c_int32
    kernel.kernel_begin_events.argtypes = (c_void_p, c_int64, c_int64)
    kernel.kernel_begin_events.restype = c_int32
    for function in (kernel.kernel_restart, kernel.kernel_leave_initialisation):
        function.argtypes, function.restype = (c_void_p, c_int64), c_int64
    kernel.link_admit.argtypes = (c_void_p, c_void_p, c_int64, c_void_p, c_int64)
    kernel.link_admit.restype = c_int64
    kernel.kernel_first_nan.argtypes = (c_void_p, c_void_p, c_int64)
    kernel.kernel_first_nan.restype = c_int64
    kernel.kernel_checksum.argtypes = (c_void_p, c_int64)
    kernel.kernel_checksum.restype = ctypes.c_uint64
    for function in (kernel.kernel_log_open, kernel.kernel_log_close):
        function.argtypes, function.restype = (c_void_p,), None
    kernel.kernel_float_mode.restype = c_int64
    kernel.kernel_restore_float_mode.argtypes = (c_int64,)
    kernel.kernel_restore_float_mode.restype = c_int64
    kernel.kernel_on_leaving.argtypes, kernel.kernel_on_leaving.restype = (c_void_p,), c_void_p
    kernel.kernel_isolated.argtypes = (c_int64, c_int64, c_int64)
    kernel.kernel_isolated.restype = c_void_p
    kernel.kernel_isolated_ask.argtypes = (c_void_p,)
    kernel.kernel_isolated_ask.restype = c_int32
    kernel.kernel_isolated_serve.argtypes = (c_void_p, c_void_p)
    kernel.kernel_isolated_serve.restype = c_int32
    kernel.kernel_log_stray.restype = ctypes.POINTER(LogStruct)
    return kernel


def function_address(function: Any) -> int:
    """The address of a function of a loaded library."""
    return ctypes.cast(function, c_void_p).value or 0
