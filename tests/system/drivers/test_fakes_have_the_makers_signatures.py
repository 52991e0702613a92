"""The fakes take what the makers' packages take; run with ``uv run --group vendors pytest``."""

from __future__ import annotations

import importlib
import inspect

import pytest

from tests.support.hil.vendor_fakes import FAKES, Maker

CALLS = {
    "moteus": {
        "moteus": [
            *("Controller.__init__", "Controller.make_query", "Controller.make_stop"),
            *("Controller.make_position", "Stream.__init__", "Stream.command"),
        ],
    },
    "nidaqmx": {
        "nidaqmx": ["Task.__init__", "Task.read", "Task.write", "Task.start", "Task.close"],
        "nidaqmx.errors": ["DaqError.__init__"],
        "nidaqmx.system.watchdog": [
            *("WatchdogTask.__init__", "WatchdogTask.cfg_watchdog_ao_expir_states"),
            *("WatchdogTask.start", "WatchdogTask.reset_timer", "WatchdogTask.clear_expiration"),
            "WatchdogTask.close",
        ],
    },
}
NAMES = {"nidaqmx": ("AngleUnits.TICKS", "EncoderType.X_4", "WatchdogAOExpirState.VOLTAGE")}


def found(module, path: str):
    for part in path.split("."):
        module = getattr(module, part)
    return module


@pytest.mark.parametrize(
    ("driver", "module", "path"),
    [(d, module, path) for d, calls in CALLS.items() for module in calls for path in calls[module]],
)
def test_call(driver: str, module: str, path: str):
    real = pytest.importorskip(module)
    fake = FAKES[driver](Maker(None))[module]
    theirs, ours = (inspect.signature(found(each, path)).parameters for each in (real, fake))
    assert list(ours) == list(theirs)
    for name, parameter in ours.items():
        assert parameter.kind is theirs[name].kind, name
        required = theirs[name].default is inspect.Parameter.empty
        assert (parameter.default is inspect.Parameter.empty) is required, name


def test_nidaqmx_has_the_channels_constants_and_tuple_that_are_used():
    pytest.importorskip("nidaqmx")
    fake = FAKES["nidaqmx"](Maker(None))
    for collection, call, member in (
        ("_ci_channel_collection", "add_ci_ang_encoder_chan", "ci_channels"),
        ("_ao_channel_collection", "add_ao_voltage_chan", "ao_channels"),
    ):
        real = importlib.import_module(f"nidaqmx.task.collections.{collection}")
        kind = next(k for k in vars(real).values() if isinstance(k, type) and call in vars(k))
        ours = getattr(fake["nidaqmx"].Task(), member)
        theirs = list(inspect.signature(getattr(kind, call)).parameters)
        assert list(inspect.signature(getattr(ours, call)).parameters) == theirs[1:]
    real = importlib.import_module("nidaqmx.constants")
    for path in NAMES["nidaqmx"]:
        assert found(real, path).value == found(fake["nidaqmx.constants"], path).value
    watchdog = importlib.import_module("nidaqmx.system.watchdog")
    ours = fake["nidaqmx.system.watchdog"].AOExpirationState
    assert watchdog.AOExpirationState._fields == ours._fields
    assert isinstance(watchdog.WatchdogTask.expired, property)
    assert issubclass(importlib.import_module("nidaqmx.errors").DaqError, real_error())


def real_error():
    return importlib.import_module("nidaqmx.errors").Error


def test_moteus_registers_and_modes_are_those_that_the_driver_knows():
    real = pytest.importorskip("moteus")
    from hil.drivers.moteus import driver

    fake = FAKES["moteus"](Maker(None))["moteus"]
    for name in ("MODE", "POSITION", "FAULT"):
        assert real.Register[name] == fake.Register[name]
    for name in ("STOPPED", "FAULT", "POSITION", "TIMEOUT"):
        assert real.Mode[name] == getattr(driver, name)
    for name in ("Fdcanusb", "PythonCan"):
        theirs = inspect.signature(getattr(real, name).cycle).parameters
        assert {"args", "kwargs"} <= set(theirs) or "commands" in theirs
    theirs = list(inspect.signature(real.Transport.cycle).parameters)
    assert list(inspect.signature(fake.Fdcanusb.cycle).parameters) == theirs
