"""The kernel's structures and constants, field by field (``sources/kernel.h``, ``events.h``)."""

from __future__ import annotations

import ctypes
from ctypes import c_double, c_int32, c_int64, c_void_p
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


class ConversionStruct(ctypes.Structure):
    """``Conversion``."""

    _fields_ = [
        ("source", c_int64),
        ("target", c_int64),
        ("from_integer", c_int64),
        ("gain", c_double),
        ("offset", c_double),
    ]


class PlayedStruct(ctypes.Structure):
    """``Played``."""

    _fields_ = [
        ("times", c_void_p),
        ("rows", c_void_p),
        ("count", c_int64),
        ("width", c_int64),
        ("is_linear", c_int64),
        ("row", c_int64),
    ]


class KnobStruct(ctypes.Structure):
    """``Knob``."""

    _fields_ = [
        ("wanted", c_void_p),
        ("minimum", c_double),
        ("maximum", c_double),
        ("is_real", c_int64),
        ("by_call", c_int64),
    ]


class ChangeStruct(ctypes.Structure):
    """``Change``; the value's eight bytes are kept as a whole number."""

    _fields_ = [("tick", c_int64), ("cell", c_int64), ("value", c_int64)]


class OperationStruct(ctypes.Structure):
    """``Operation``."""

    _fields_ = [
        ("kind", c_int32),
        ("owner", c_int32),
        ("type", c_int32),
        ("version", c_int32),
        ("function", c_void_p),
        ("references", c_void_p),
        ("reference_count", c_int64),
        ("cells", c_void_p),
        ("cell_count", c_int64),
        ("scratch", c_void_p),
        ("table", c_void_p),
        ("copy_count", c_int64),
    ]


class InstanceStruct(ctypes.Structure):
    """``Instance``."""

    _fields_ = [
        ("instance", c_void_p),
        ("do_step", c_void_p),
        ("version", c_int64),
        ("period", c_int64),
        ("substeps", c_int64),
        ("step", c_double),
        ("foreign", c_int64),
        ("warnings", c_int64),
        ("is_plain", c_int64),
        ("events", c_void_p),
    ]


class EventClockStruct(ctypes.Structure):
    """``EventClock``."""

    _fields_ = [
        ("kind", c_int64),
        ("reference", c_void_p),
        ("interval", c_int64),
        ("shift", c_int64),
        ("of", c_int64),
        ("input", c_void_p),
        ("cells", c_void_p),
    ]


class EventAccessStruct(ctypes.Structure):
    """``EventAccess``."""

    _fields_ = [
        ("operation", c_int64),
        ("clocks", c_int64),
        ("at_start", c_int64),
        ("before", c_void_p),
    ]


class EventsStruct(ctypes.Structure):
    """``Events``."""

    _fields_ = [
        ("enter", c_void_p),
        ("leave", c_void_p),
        ("update", c_void_p),
        ("set_clock", c_void_p),
        ("get_clock", c_void_p),
        ("get_interval", c_void_p),
        ("get_shift", c_void_p),
        ("clocks", c_void_p),
        ("clock_count", c_int64),
        ("sets", c_void_p),
        ("set_count", c_int64),
        ("gets", c_void_p),
        ("get_count", c_int64),
        ("next", c_void_p),
        ("may_return", c_int64),
        ("turned", c_int64),
    ]


class InstantStruct(ctypes.Structure):
    """``Instant``."""

    _fields_ = [("step", c_int64), ("beyond", c_double)]


class BundleStruct(ctypes.Structure):
    """``Bundle``."""

    _fields_ = [
        ("period", c_int64),
        ("width", c_int64),
        ("sources", c_void_p),
        ("held", c_void_p),
        ("age", c_void_p),
        ("held_sequence", c_void_p),
        ("sampled", c_int64),
        ("sequence", c_int64),
        ("immediate", c_int64),
        ("delay", c_int64),
        ("fates", c_void_p),
        ("copies", c_void_p),
        ("fate_first", c_int64),
        ("fate_count", c_int64),
        ("capacity", c_int64),
        ("in_flight", c_int64),
        ("next_arrival", c_int64),
        ("arrival", c_void_p),
        ("flight_sequence", c_void_p),
        ("flight_sampled", c_void_p),
        ("payload", c_void_p),
        ("sent", c_int64),
        ("delivered", c_int64),
        ("lost", c_int64),
        ("late", c_int64),
        ("duplicate", c_int64),
    ]


class RecordStruct(ctypes.Structure):
    """``Record``."""

    _fields_ = [("rows", c_void_p), ("row", c_int64), ("row_count", c_int64)]


class KernelStruct(ctypes.Structure):
    """``Kernel``."""

    _fields_ = [
        ("cells", c_void_p),
        ("operations", c_void_p),
        ("program", c_void_p),
        ("run_length", c_void_p),
        ("program_start", c_void_p),
        ("pattern", c_void_p),
        ("hyperperiod", c_int64),
        ("first_program", c_int64),
        ("instances", c_void_p),
        ("bundles", c_void_p),
        ("records", c_void_p),
        ("tick_numerator", c_int64),
        ("tick_denominator", c_int64),
        ("start_tick", c_int64),
        ("changes", c_void_p),
        ("change_count", c_int64),
        ("next_change", c_int64),
        ("float_mode", c_int64),
        ("has_foreign", c_int64),
        ("careful", c_int64),
        ("tick", c_int64),
        ("phase", c_int64),
        ("running", c_int64),
        ("position", c_int64),
        ("kind", c_int64),
        ("owner", c_int64),
        ("operation", c_int64),
        ("status", c_int64),
        ("cell", c_int64),
        ("event_call", c_int64),
        ("event_fault", c_int64),
        ("event_clock", c_int64),
        ("event_value", c_double),
    ]


class AdmissionStruct(ctypes.Structure):
    """``Admission``."""

    _fields_ = [
        ("size", c_int64),
        ("minimum", c_void_p),
        ("maximum", c_void_p),
        ("step", c_void_p),
        ("whole", c_void_p),
        ("reference", c_void_p),
    ]


class LogStruct(ctypes.Structure):
    """``Log``."""

    _fields_ = [
        ("text", c_void_p),
        ("grave", c_void_p),
        ("capacity", c_int64),
        ("used", c_int64),
        ("grave_used", c_int64),
        ("messages", c_int64),
        ("next", c_void_p),
    ]


class ExchangeStruct(ctypes.Structure):
    """``Exchange``."""

    _fields_ = [
        ("asked", c_int64),
        ("answered", c_int64),
        ("worker_sleeps", c_int64),
        ("master_sleeps", c_int64),
        ("request", c_int64),
        ("status", c_int64),
        ("most_references", c_int64),
        ("most_bytes", c_int64),
        ("reference_count", c_int64),
        ("value_count", c_int64),
        ("time", c_double),
        ("step", c_double),
        ("event", c_int64),
        ("terminate", c_int64),
        ("early_return", c_int64),
        ("last_time", c_double),
    ]


class IsolationStruct(ctypes.Structure):
    """``Isolation``."""

    _fields_ = [
        ("exchange", c_void_p),
        ("read", c_void_p),
        ("write", c_void_p),
        ("ear", c_int64),
        ("mouth", c_int64),
        ("looks", c_int64),
        ("version", c_int64),
        ("functions", c_void_p),
        ("is_gone", c_int64),
    ]


class SettingStruct(ctypes.Structure):
    """``Setting``."""

    _fields_ = [
        ("function", c_void_p),
        ("references", c_void_p),
        ("reference_count", c_int64),
        ("values", c_void_p),
        ("value_count", c_int64),
    ]


class RestartStruct(ctypes.Structure):
    """``Restart``."""

    _fields_ = [
        ("instance", c_void_p),
        ("version", c_int64),
        ("reset", c_void_p),
        ("set_up", c_void_p),
        ("enter", c_void_p),
        ("leave", c_void_p),
        ("settings", c_void_p),
        ("setting_count", c_int64),
        ("log", c_void_p),
        ("start", c_double),
        ("stop", c_double),
        ("status", c_int64),
    ]
