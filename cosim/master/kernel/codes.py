"""The kernel's constants, number by number (``sources/kernel.h``, ``events.h``)."""

from __future__ import annotations

from enum import IntEnum

from cosim.base.component import VariableType


class KernelOutcome(IntEnum):
    """Why the kernel came back."""

    DONE = 0
    CALL = 1
    STATUS = 2
    NOT_A_NUMBER = 3
    RANGE = 4
    EARLY_RETURN = 5
    TERMINATED = 6
    OVERFLOW = 7
    EVENT = 8


class EventCall(IntEnum):
    """What an FMU is called for at an event."""

    NONE = 0
    ENTER = 1
    SET_CLOCK = 2
    SET = 3
    GET_CLOCK = 4
    GET = 5
    UPDATE = 6
    GET_INTERVAL = 7
    LEAVE = 8
    GET_SHIFT = 9


class EventFault(IntEnum):
    """What an FMU in event mode cannot be followed in."""

    NONE = 0
    NO_END = 1
    OFF_GRID = 2
    NO_INTERVAL = 3
    RETURNS = 4
    TIME = 5
    NO_TIME = 6


class ClockKind(IntEnum):
    """Who says when a clock ticks."""

    PERIODIC = 0
    TUNABLE = 1
    CHANGING = 2
    COUNTDOWN = 3
    TRIGGERED = 4
    TOLD = 5


CLOCK_CELLS = 6
"""Of each clock, from ``EventClockStruct.cells`` on."""


CLOCK_COUNT, CLOCK_AGE = 2, 3
"""Which of them others see: how often it has ticked, and how many ticks ago the last time."""


class OperationKind(IntEnum):
    """What an operation does."""

    COPY = 0
    CONVERT = 1
    SET_FLOAT64 = 2
    GET_FLOAT64 = 3
    SET = 4
    GET = 5
    STEP = 6
    CALL = 7
    DELIVER = 8
    SAMPLE = 9
    SEND = 10
    RECORD = 11
    TUNE = 12
    PLAY = 13
    STEP_IN_PARTS = 14


TYPE_CODES = {
    VariableType.FLOAT64: 0,
    VariableType.FLOAT32: 1,
    VariableType.INT8: 2,
    VariableType.UINT8: 3,
    VariableType.INT16: 4,
    VariableType.UINT16: 5,
    VariableType.INT32: 6,
    VariableType.UINT32: 7,
    VariableType.INT64: 8,
    VariableType.UINT64: 9,
    VariableType.BOOLEAN: 10,
    VariableType.ENUMERATION: 8,
}
"""How an FMI 3 function passes a value of each type; FMI 2 has an int behind all but reals."""


FMI2_TYPE_CODES = {
    VariableType.FLOAT64: 0,
    VariableType.INT32: 6,
    VariableType.ENUMERATION: 6,
    VariableType.BOOLEAN: 11,
}
