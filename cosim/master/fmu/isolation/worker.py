"""The process of an isolated FMU: it calls the FMU for the kernel of another process.

It is started by ``isolated.py``, and ends when that one asks for it or is gone. Ctrl-C is none of
its business.
"""

from __future__ import annotations

import ctypes
import os
import signal
import socket
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from cosim.base.errors import InputError
from cosim.master.fmu.binding import EVENT_FUNCTIONS, Binding
from cosim.master.fmu.fmi2 import TYPES as TYPES2
from cosim.master.fmu.fmi2 import Fmi2
from cosim.master.fmu.fmi3 import TYPES as TYPES3
from cosim.master.fmu.fmi3 import Fmi3
from cosim.master.fmu.isolation.exchange import Exchange, Room, receive, send
from cosim.master.fmu.library import take_library
from cosim.master.kernel.codes import FMI2_TYPE_CODES, TYPE_CODES
from cosim.master.kernel.native import function_address, library

_PR_SET_PDEATHSIG = 1
_OF_EVENTS = 25
_REQUESTS = _OF_EVENTS + len(EVENT_FUNCTIONS)
"""A step, a set and a get for each of the kernel's types, and event mode (``isolation.h``)."""


def work(settings: Mapping[str, Any]) -> None:
    """Serve until the master is gone; never returns."""
    status = 1
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        if sys.platform == "linux":
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
        for file in settings["files"]:
            os.set_inheritable(file, False)
        _Worker(settings).serve()
        status = 0
    finally:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        ctypes.CDLL(None).fflush(None)
        os._exit(status)


class _Worker:
    def __init__(self, settings: Mapping[str, Any]) -> None:
        file, ear, mouth, talk = settings["files"]
        self._exchange = Exchange(
            file, Room(*settings["room"]), ear, mouth, looks=settings["looks"]
        )
        self._talk = socket.socket(fileno=talk)
        self._version: int = settings["version"]
        self._library = Path(settings["library"])
        self._binding: Binding | None = None
        self._functions: Any = (ctypes.c_void_p * _REQUESTS)()

    def serve(self) -> None:
        side = self._exchange.side
        side.version, side.functions = self._version, ctypes.addressof(self._functions)
        serve = library().kernel_isolated_serve
        while serve(ctypes.addressof(side), self._binding.handle if self._binding else 0):
            with suppress(EOFError, OSError):
                method, arguments = receive(self._talk)
                send(self._talk, self._answer(method, arguments))

    def _answer(self, method: str, arguments: Any) -> tuple[bool, Any]:
        """Whether it went well, and the result or the exception."""
        try:
            if method == "load":
                self._load()
                return True, None
            assert self._binding is not None, "the library is loaded first"
            return True, getattr(self._binding, method)(*arguments)
        except (InputError, ValueError, TypeError, OverflowError, ctypes.ArgumentError) as error:
            return False, error

    def _load(self) -> None:
        exchange = self._exchange
        exchange.note("the loading of its library")
        functions = take_library(self._library, self._version)
        exchange.log.open()
        bound, types, codes = (
            (Fmi2, TYPES2, FMI2_TYPE_CODES) if self._version == 2 else (Fmi3, TYPES3, TYPE_CODES)
        )
        self._binding = bound(functions, exchange.log.address, exchange.note)
        table: Any = self._functions
        table[0] = self._binding.do_step_address()
        for number, name in enumerate(EVENT_FUNCTIONS):
            function = f"fmi{self._version}{name}"
            if function in functions:
                table[_OF_EVENTS + number] = function_address(functions[function])
        for kind, (name, _) in types.items():
            for is_set, verb in enumerate(("Get", "Set")):
                function = f"fmi{self._version}{verb}{name}"
                if kind in codes and function in functions:
                    table[1 + 2 * codes[kind] + is_set] = function_address(functions[function])
