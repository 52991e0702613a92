"""A force sensor as a component: outputs alone, read as a tick begins."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from cosim.base.component import Causality, Cells, Setup, Variable, VariableType
from cosim.base.errors import InputError
from cosim.base.system.supervised import Opening
from hil.device.board.component import BoardComponent, begin_emulated_motion
from hil.sensing.sensor import Sensor
from hil.sensing.sensor_driver import SensorDriver
from hil.sensing.sensor_file import SensorFile, load, parse
from hil.setup import session as sessions

_OUTPUTS = (
    ("force", VariableType.FLOAT64, "N", (3,), "Force on the sensor; NaN along an unmeasured axis"),
    ("torque", VariableType.FLOAT64, "N.m", (3,), "Torque on it; NaN about an unmeasured axis"),
    ("sample_age", VariableType.INT32, None, (), "Ticks since the last new sample"),
    ("status", VariableType.INT32, None, (), "Bits: 1 open, 2 fault, 4 at the end of its range"),
)


class SensorComponent(BoardComponent[SensorDriver]):
    """It has no input: nothing that a scenario connects can reach the board."""

    feedthrough = False

    def __init__(self, kind: type[SensorDriver], url: str, options: Mapping[str, Any]) -> None:
        super().__init__(kind, url, options)
        self.file = sensor_file(kind, options)
        self.sensor: Sensor | None = None
        self._started = False
        self._owner = 0
        """The process that opened it; it alone closes the port."""

    @property
    def variables(self) -> Sequence[Variable]:
        """Force, torque, and what is known of them."""
        return tuple(
            Variable(
                name=name,
                type=kind,
                causality=Causality.OUTPUT,
                variability="continuous" if kind.is_float else "discrete",
                unit=unit,
                shape=shape,
                description=description,
            )
            for name, kind, unit, shape, description in _OUTPUTS
        )

    def ask(self) -> None:
        """Nothing has to be asked of people: it cannot push."""

    def rehearse(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Show no load; nothing is opened."""
        for cells in outputs.values():
            cells[...] = 0

    def open(self, opening: Opening) -> Sensor:
        """Open and tare it."""
        session = sessions.current()
        if self.file.tare:
            session.tell(f"{self.address.url} is tared: keep hands and loads off it")
        sensor = Sensor(
            self.kind,
            self.address,
            self.file,
            tick=opening.tick,
            pulse=opening.pulse,
            number=opening.number,
            alarm=session.alarm,
        )
        sensor.configure()
        self.sensor, self._owner = sensor, os.getpid()
        return sensor

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Have the first sample.

        Raises:
            DeviceError: the sensor does not answer, or cannot be tared.
            InputError: its address cannot be used, or it lives in real time and this run does not.
        """
        self._force, self._torque = outputs["force"], outputs["torque"]
        self._age, self._status = outputs["sample_age"], outputs["status"]
        if self.sensor is None:
            if not self.lockstep:
                raise InputError(
                    f"{setup.name} is a real device ({self.address.url}): run it with --realtime"
                )
            self.open(
                Opening(
                    name=setup.name,
                    number=0,
                    tick=Fraction(*setup.tick) * setup.period,
                    parameters=setup.parameters,
                )
            )
        sensor = self._opened()
        sensor.ask()
        self._show()

    def read(self, tick: int) -> None:
        """Take the measurement that the last tick asked for."""
        del tick
        if not self._started:
            begin_emulated_motion(self.address)
            self._started = True
        self._opened().read()
        self._show()

    def write(self, tick: int) -> None:
        """Ask for the next one; a fault ends the run.

        Raises:
            DeviceFault: the sensor is in FAULT.
        """
        del tick
        sensor = self._opened()
        sensor.ask()
        self._status[0] = int(sensor.status)
        sensor.raise_fault()

    def close(self) -> None:
        """Let go of it where it was opened here, and nobody else has it."""
        if self.sensor is not None and self._owner == os.getpid():
            self.sensor.close()
            self.sensor = None

    def _show(self) -> None:
        sensor = self._opened()
        self._force[:], self._torque[:] = sensor.wrench.force, sensor.wrench.torque
        self._age[0], self._status[0] = sensor.age, int(sensor.status)

    def _opened(self) -> Sensor:
        assert self.sensor is not None, "initialise comes first"
        return self.sensor


def sensor_file(kind: type[SensorDriver], options: Mapping[str, Any]) -> SensorFile:
    """The file that a scenario's options name, or the published sensor.

    Raises:
        InputError: it cannot be used, or belongs to another driver.
    """
    path, preset = options.get("file"), options.get("preset")
    if path is not None and preset is not None:
        raise InputError(f"'preset' has no effect beside 'file': write it into {path}")
    if path is None:
        plain = {"driver": kind.driver} | ({} if preset is None else {"preset": str(preset)})
        return parse(plain, kind.known, kind.preset)
    file = load(Path(str(path)).expanduser(), kind.known, kind.preset)
    if file.driver != kind.driver:
        raise InputError(f"{path} is a device file for '{file.driver}', not for '{kind.driver}'")
    return file
