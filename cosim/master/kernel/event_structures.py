"""The kernel's structures for FMUs in event mode, field by field (``sources/events.h``)."""

from __future__ import annotations

import ctypes
from ctypes import c_double, c_int64, c_void_p


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
