"""The structures of a program, field by field (``sources/kernel.h``)."""

from __future__ import annotations

import ctypes
from ctypes import c_double, c_int32, c_int64, c_void_p


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
        ("items", c_void_p),
        ("item_count", c_int64),
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
        ("instance", c_void_p),
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
        ("events", c_void_p),
    ]


class RunStruct(ctypes.Structure):
    """``Run``."""

    _fields_ = [("first", c_void_p), ("end", c_void_p)]


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
        ("runs", c_void_p),
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
