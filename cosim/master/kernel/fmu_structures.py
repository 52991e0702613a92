"""Structures of an FMU outside of a program: its log, its own process, its restart."""

from __future__ import annotations

import ctypes
from ctypes import c_double, c_int64, c_void_p


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
        ("request", c_int64),
        ("most_references", c_int64),
        ("most_bytes", c_int64),
        ("reference_count", c_int64),
        ("value_count", c_int64),
        ("time", c_double),
        ("step", c_double),
        ("answered", c_int64),
        ("status", c_int64),
        ("event", c_int64),
        ("terminate", c_int64),
        ("early_return", c_int64),
        ("last_time", c_double),
        ("worker_sleeps", c_int64),
        ("master_sleeps", c_int64),
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
