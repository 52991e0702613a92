"""What a run is doing, in memory that a parent can still read when the run's process has died."""

from __future__ import annotations

import ctypes
import mmap
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

from cosim.master.fmu.log import LOG_BYTES, Log, Said
from cosim.master.kernel.codes import EventCall, OperationKind
from cosim.master.kernel.structures import KernelStruct
from cosim.scenario import Kind as ComponentKind
from cosim.scenario import Scenario

_NOTE_BYTES = 1024
_HEARD = _NOTE_BYTES - 1
"""The byte that counts interrupts; a note ends before it."""
LOGS = 16
"""FMUs of somebody else whose logs can be read when the process has died."""
_STATE_BYTES = -(-(_NOTE_BYTES + ctypes.sizeof(KernelStruct)) // 64) * 64
_GRAIN = mmap.ALLOCATIONGRANULARITY
SPAN = -(-(_STATE_BYTES + LOGS * LOG_BYTES) // _GRAIN) * _GRAIN
"""Bytes that one takes of a file."""
_KERNEL_DID = {
    OperationKind.SET: "while its inputs were set",
    OperationKind.SET_FLOAT64: "while its inputs were set",
    OperationKind.GET: "while its outputs were read",
    OperationKind.GET_FLOAT64: "while its outputs were read",
    OperationKind.TUNE: "while a parameter was turned",
    OperationKind.STEP: "in its step",
    OperationKind.STEP_IN_PARTS: "in its step",
    OperationKind.CALL: "in a method of its class",
}

AT_EVENTS = {
    EventCall.ENTER: "in fmi3EnterEventMode",
    EventCall.SET_CLOCK: "in fmi3SetClock",
    EventCall.SET: "while its inputs were set at an event",
    EventCall.GET_CLOCK: "in fmi3GetClock",
    EventCall.GET: "while its outputs were read at an event",
    EventCall.UPDATE: "in fmi3UpdateDiscreteStates",
    EventCall.GET_INTERVAL: "in fmi3GetIntervalDecimal",
    EventCall.LEAVE: "in fmi3EnterStepMode",
    EventCall.GET_SHIFT: "in fmi3GetShiftDecimal",
}
"""Where an FMU is at an event, in words."""


class Whereabouts:
    """The kernel's own structure and a note of the call outside of the kernel.

    The memory is shared with processes that are forked after it was made, or with whoever has the
    same ``number`` of the same ``file`` (an open one of ``SPAN`` bytes for each number).
    """

    def __init__(self, file: int = -1, number: int = 0) -> None:
        self._memory = mmap.mmap(file, SPAN, offset=number * SPAN)
        self._logs = memoryview(self._memory)[_STATE_BYTES:]
        self._foreign: tuple[Scenario | None, dict[str, int]] = (None, {})
        self.is_watched = False
        """Whether another process will tell how this one has ended."""
        self.kernel: Any = KernelStruct.from_buffer(self._memory, _NOTE_BYTES)

    def note(self, component: str, call: str) -> None:
        """A function of a component is about to be called, not by the kernel; none: it is over."""
        if not call:
            self.clear()
            return
        text = f"{component}\n{call}".encode()[: _HEARD - 1]
        self._memory[: len(text) + 1] = text + b"\0"

    def clear(self) -> None:
        """No such call is going on: the kernel's structure says what is."""
        self._memory[0] = 0

    @contextmanager
    def aside(self) -> Generator[None]:
        """What is noted inside is forgotten afterwards, and what was noted before counts again."""
        before = self._memory[:_HEARD]
        yield
        self._memory[:_HEARD] = before

    def forget(self) -> None:
        """Be as new, for another run; the last one's kernel has ended."""
        self._memory[:_STATE_BYTES] = bytes(_STATE_BYTES)

    def place(self) -> bytes:
        """Where the run is, and what it has heard: the same as long as it does not move."""
        kernel = self.kernel
        where = (kernel.tick, kernel.running, kernel.position, kernel.owner, kernel.event_call)
        return bytes(self._memory[:_NOTE_BYTES]) + repr(where).encode()

    def hear(self) -> None:
        """Count an interrupt that the run has heard."""
        self._memory[_HEARD] = (self._memory[_HEARD] + 1) % 256

    @property
    def heard(self) -> int:
        """How many interrupts the run has heard (modulo 256)."""
        return self._memory[_HEARD]

    def log(self, component: str, scenario: Scenario) -> Log:
        """Where an FMU's messages go: those of the first of somebody else's outlive the process."""
        if self._foreign[0] is not scenario:
            self._foreign = scenario, _foreign(scenario)
        number = self._foreign[1].get(component, LOGS)
        begin = number * LOG_BYTES
        return Log(self._logs[begin : begin + LOG_BYTES] if number < LOGS else None)

    def said(self, scenario: Scenario) -> dict[str, tuple[Said, ...]]:
        """What is in the logs that outlive the process, by component."""
        logs = {name: self.log(name, scenario) for name in list(_foreign(scenario))[:LOGS]}
        return {name: found for name, log in logs.items() if (found := log.said())}

    def sentence(self, scenario: Scenario) -> tuple[str, str]:
        """Which component was at work, or nobody, and in what: ``in its step at tick 5 (0.005 s)``.

        ``scenario`` is the one that ran; its components give the numbers their names.
        """
        when = self.when(scenario)
        text = bytes(self._memory[:_HEARD]).split(b"\0", 1)[0].decode(errors="replace")
        if text:
            component, call = text.split("\n", 1)
            return component, f"in {call} {when}"
        names = sorted(scenario.components)
        if self.kernel.running >= 0 and self.kernel.kind in _KERNEL_DID:
            if self.kernel.kind != OperationKind.CALL:
                kinds = {name: part.kind for name, part in scenario.components.items()}
                names = [name for name in names if kinds[name] is ComponentKind.FMU]
            did = _KERNEL_DID[OperationKind(self.kernel.kind)]
            if self.kernel.kind == OperationKind.STEP_IN_PARTS and self.kernel.event_call:
                did = AT_EVENTS[EventCall(self.kernel.event_call)]
            when = when if self.kernel.running else "at initialisation"
            return names[int(self.kernel.owner)], f"{did} {when}"
        return "", when

    def when(self, scenario: Scenario) -> str:
        """The time that the run has come to: ``at tick 5 (0.005 s)``."""
        tick = int(self.kernel.tick)
        if tick == 0 and self.kernel.running <= 0:
            return "before the first tick"
        seconds = float((scenario.start_tick + tick) / scenario.base_rate)
        return f"at tick {tick} ({seconds:g} s)"


def _foreign(scenario: Scenario) -> dict[str, int]:
    """The FMUs of somebody else, with their numbers."""
    parts = sorted(scenario.components.items())
    names = [n for n, part in parts if part.kind is ComponentKind.FMU and not part.is_bundled]
    return {name: number for number, name in enumerate(names)}
