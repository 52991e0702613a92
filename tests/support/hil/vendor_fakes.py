"""The parts of the makers' packages that the drivers use, with their true signatures.

``quanser.hardware`` after Quanser's documentation (the package is not on PyPI), ``nidaqmx`` and
``moteus`` after the packages themselves: ``test_fakes_have_the_makers_signatures`` compares them
where those are installed. ``broken`` names the calls that raise, ``has_watchdog`` takes it away.
"""

# ruff: noqa: PLR0917, A002
from __future__ import annotations

from array import array
from collections import namedtuple
from enum import Enum, IntEnum
from math import isnan, nan
from types import ModuleType, SimpleNamespace
from typing import Any

TICK = 1 / 1024
TORQUE_PER_VOLT = 0.0364 * 0.5
COUNTS = 20000


class Maker:
    """What the test knows of a fake's inside."""

    def __init__(self, board: Any) -> None:
        self.board = board
        self.broken: set[str] = set()
        self.has_watchdog = True
        self.silent = False
        """A bus without answers (moteus)."""
        self.deaf = False
        """Controllers that do not stop (moteus)."""
        self.no_number = False
        """Positions that are no numbers."""
        self.timeout_mode = b"0"
        self.open = 0
        self.mode = {1: 0, 2: 0}
        """moteus controllers' mode registers."""

    def volts(self, values: Any) -> None:
        first, second = (float(value) * TORQUE_PER_VOLT for value in values)
        assert not self.board.state()["expired"], "checked by the fakes before"
        self.board.write((first + 0.0, second + 0.0))


def quanser(maker: Maker) -> dict[str, ModuleType]:
    """``quanser.hardware``: HIL, HILError, DigitalState."""

    class GenericError(Exception):
        def __init__(self, error_code):
            self.error_code = error_code

        def get_error_message(self, locale=None, buffer_size=-1):
            return f"the maker's words for {self.error_code}"

    class HILError(GenericError):
        pass

    class DigitalState:
        LOW, HIGH, TRISTATE, NO_CHANGE = range(4)

    def check(call: str) -> None:
        if call in maker.broken:
            raise HILError(-1)

    class HIL:
        def __init__(self, card_type=None, card_identifier=None):
            check("open")
            maker.open += 1

        def close(self):
            maker.open -= 1

        def read_encoder(self, channels, num_channels, buffer):
            check("read")
            assert (channels.typecode, buffer.typecode) == ("I", "i")
            buffer[:num_channels] = array("i", maker.board.count(COUNTS))

        def write_analog(self, channels, num_channels, buffer):
            check("write")
            assert (channels.typecode, buffer.typecode, num_channels) == ("I", "d", 2)
            if maker.board.state()["expired"]:
                raise HILError(-2)
            maker.volts(buffer)

        def watchdog_set_analog_expiration_state(self, channels, num_channels, voltages):
            if not maker.has_watchdog:
                raise HILError(-3)
            assert list(voltages) == [0.0, 0.0]
            maker.board.protect((0.0, 0.0))

        def watchdog_set_digital_expiration_state(self, channels, num_channels, states):
            assert list(states) == [DigitalState.TRISTATE] * num_channels

        def watchdog_start(self, timeout):
            maker.board.arm(int(timeout / TICK))

        def watchdog_stop(self):
            maker.board.disarm()

        def watchdog_reload(self):
            check("feed")
            return maker.board.feed()

        def watchdog_is_expired(self):
            return maker.board.state()["expired"]

        def watchdog_clear(self):
            maker.board.clear()

    return _modules("quanser.hardware", HIL=HIL, HILError=HILError, DigitalState=DigitalState)


def nidaqmx(maker: Maker) -> dict[str, ModuleType]:
    """``nidaqmx`` with ``constants``, ``errors`` and ``system.watchdog``."""

    class Error(Exception):
        pass

    class DaqError(Error):
        def __init__(self, message, error_code, task_name=""):
            super().__init__(message)

    class EncoderType(Enum):
        X_4 = 10092

    class AngleUnits(Enum):
        DEGREES, TICKS = 10146, 10304

    class WatchdogAOExpirState(Enum):
        VOLTAGE = 10322

    AOExpirationState = namedtuple(
        "AOExpirationState", ["physical_channel", "expiration_state", "output_type"]
    )

    def check(call: str) -> None:
        if call in maker.broken:
            raise DaqError("the maker's words", -200284)

    class Counters:
        def __init__(self, task):
            self._task = task

        def add_ci_ang_encoder_chan(
            self,
            counter,
            name_to_assign_to_channel="",
            decoding_type=EncoderType.X_4,
            zidx_enable=False,
            zidx_val=0,
            zidx_phase=None,
            units=AngleUnits.DEGREES,
            pulses_per_rev=24,
            initial_angle=0.0,
            custom_scale_name="",
        ):
            assert units is AngleUnits.TICKS
            self._task.counter = int(counter.removeprefix("Dev1/ctr"))

    class Outputs:
        def __init__(self, task):
            self._task = task

        def add_ao_voltage_chan(
            self,
            physical_channel,
            name_to_assign_to_channel="",
            min_val=-10.0,
            max_val=10.0,
            units=None,
            custom_scale_name="",
        ):
            self._task.outputs.append(physical_channel)

    class Task:
        def __init__(self, new_task_name="", *, grpc_options=None):
            check("open")
            self.ci_channels, self.ao_channels = Counters(self), Outputs(self)
            self.outputs, self.counter = [], None
            maker.open += 1

        def start(self):
            assert self.counter is not None

        def read(self, number_of_samples_per_channel=None, timeout=10.0):
            check("read")
            return nan if maker.no_number else float(maker.board.count(COUNTS)[self.counter])

        def write(self, data, auto_start=None, timeout=10.0):
            check("write")
            assert self.outputs == ["Dev1/ao0", "Dev1/ao1"]
            if maker.board.state()["expired"]:
                raise DaqError("the card is locked", -200678)
            maker.volts(data)
            return 1

        def close(self):
            maker.open -= 1

    class WatchdogTask:
        def __init__(self, device_name, task_name="", timeout=10, grpc_options=None):
            if not maker.has_watchdog:
                raise DaqError("this device has no watchdog timer", -200662)
            self._ticks = int(timeout / TICK)
            maker.open += 1

        def cfg_watchdog_ao_expir_states(self, expiration_states):
            assert [state.physical_channel for state in expiration_states] == [
                "Dev1/ao0",
                "Dev1/ao1",
            ]
            assert [state.expiration_state for state in expiration_states] == [0.0, 0.0]
            maker.board.protect((0.0, 0.0))

        def start(self):
            maker.board.arm(self._ticks)

        @property
        def expired(self):
            return maker.board.state()["expired"]

        def reset_timer(self):
            check("feed")
            maker.board.feed()

        def clear_expiration(self):
            maker.board.clear()

        def close(self):
            maker.board.disarm()
            maker.open -= 1

    return {
        **_modules(
            "nidaqmx.constants",
            EncoderType=EncoderType,
            AngleUnits=AngleUnits,
            WatchdogAOExpirState=WatchdogAOExpirState,
        ),
        **_modules("nidaqmx.errors", Error=Error, DaqError=DaqError),
        **_modules(
            "nidaqmx.system.watchdog",
            WatchdogTask=WatchdogTask,
            AOExpirationState=AOExpirationState,
        ),
        **_modules("nidaqmx", Task=Task),
    }


def moteus(maker: Maker) -> dict[str, ModuleType]:
    """``moteus``: Controller, Fdcanusb, PythonCan, Stream, Register; servos that a stop clears."""

    class Register(IntEnum):
        MODE, POSITION, FAULT = 0x000, 0x001, 0x00F

    wanted: dict[int, float] = {1: 0.0, 2: 0.0}

    def settle() -> None:
        if maker.board.state()["expired"]:
            for number, mode in maker.mode.items():
                if mode == 10:
                    maker.mode[number] = 11
        running = [wanted[n] if maker.mode[n] == 10 else 0.0 for n in (1, 2)]
        maker.board.write((running[0], running[1]))

    class Controller:
        def __init__(
            self,
            id=1,
            query_resolution=None,
            position_resolution=None,
            vfoc_resolution=None,
            current_resolution=None,
            pwm_resolution=None,
            zero_velocity_resolution=None,
            transport=None,
            source_can_id=0,
            can_prefix=0x0000,
        ):
            self.id = id

        def make_query(self, query_override=None):
            return SimpleNamespace(id=self.id, kind="query")

        def make_stop(self, *, query=False, query_override=None):
            return SimpleNamespace(id=self.id, kind="stop")

        def make_position(
            self,
            *,
            position=None,
            velocity=None,
            feedforward_torque=None,
            kp_scale=None,
            kd_scale=None,
            maximum_torque=None,
            stop_position=None,
            watchdog_timeout=None,
            velocity_limit=None,
            accel_limit=None,
            fixed_voltage_override=None,
            ilimit_scale=None,
            fixed_current_override=None,
            ignore_position_bounds=None,
            query=False,
            query_override=None,
        ):
            assert isnan(position), "wherever it is"
            assert (kp_scale, kd_scale, ilimit_scale) == (0.0, 0.0, 0.0)
            torque = max(-maximum_torque, min(maximum_torque, feedforward_torque))
            return SimpleNamespace(
                id=self.id, kind="position", torque=torque, timeout=watchdog_timeout
            )

    class Transport:
        def __init__(self, *args, **kwargs):
            if "open" in maker.broken:
                raise RuntimeError("no such bus")
            maker.open += 1

        async def cycle(
            self, commands, request_attitude=False, read_unsolicited=None, force_can_check=None
        ):
            answers = []
            for command in commands:
                if command.kind == "query":
                    if "read" in maker.broken:
                        raise RuntimeError("the maker's words")
                    settle()
                    turns = maker.board.count(COUNTS)[command.id - 1] / COUNTS
                    turns = nan if maker.no_number else turns
                    values = {
                        Register.MODE: maker.mode[command.id],
                        Register.POSITION: turns,
                        Register.FAULT: 0,
                    }
                    if not maker.silent:
                        answers.append(SimpleNamespace(id=command.id, values=values))
                    continue
                if "write" in maker.broken:
                    raise RuntimeError("the maker's words")
                if command.kind == "stop" and maker.deaf:
                    continue
                if command.kind == "stop":
                    maker.mode[command.id], wanted[command.id] = 0, 0.0
                    if set(maker.mode.values()) == {0}:
                        maker.board.clear()
                        maker.board.disarm()
                else:
                    settle()
                    if maker.mode[command.id] in {0, 10}:
                        maker.mode[command.id], wanted[command.id] = 10, command.torque
                        if maker.has_watchdog:
                            maker.board.arm(int(command.timeout / TICK))
                settle()
            return answers

        def close(self):
            maker.open -= 1

    class Stream:
        def __init__(self, controller, verbose=False, channel=1, use_flow_control=None):
            pass

        async def command(self, data, allow_any_response=False):
            assert data == b"conf get servo.timeout_mode"
            return maker.timeout_mode + b"\n"

    return _modules(
        "moteus",
        Controller=Controller,
        Fdcanusb=type("Fdcanusb", (Transport,), {}),
        PythonCan=type("PythonCan", (Transport,), {}),
        Stream=Stream,
        Register=Register,
    )


def _modules(name: str, **contents: Any) -> dict[str, ModuleType]:
    """The module and the packages above it."""
    made: dict[str, ModuleType] = {}
    parts = name.split(".")
    for size in range(1, len(parts)):
        made[".".join(parts[:size])] = ModuleType(".".join(parts[:size]))
    module = ModuleType(name)
    vars(module).update(contents)
    return {**made, name: module}


FAKES = {"quanser": quanser, "nidaqmx": nidaqmx, "moteus": moteus}
