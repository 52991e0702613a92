"""A device as a component: it takes the pantograph FMU's place, variable by variable."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from fractions import Fraction
from math import nan
from pathlib import Path
from typing import Any

from cosim.base.component import Cells, Role, Setup, Variable
from cosim.base.document.form import plain_node, read_form
from cosim.base.errors import InputError, Location
from cosim.base.system.supervised import Opening
from hil.device.board.component import BoardComponent, begin_emulated_motion
from hil.device.contract import Flag, Measurement, State
from hil.device.device import Device
from hil.device.driver import Driver
from hil.device.pantograph import terminals, variables
from hil.device.warnings import warnings_of
from hil.safety.form import SafetyForm
from hil.setup import session as sessions
from hil.setup.device_file import DeviceFile, default, load
from hil.setup.watchdog_proof import prove_at_opening


class DeviceComponent(BoardComponent[Driver]):
    """Read at the beginning of a tick, write once the torque is known.

    Variables of role ``simulation_only`` are all there: such an input is accepted and ignored, such
    an output is NaN (a whole number: 0).
    """

    feedthrough = True

    def __init__(
        self,
        kind: type[Driver],
        url: str,
        options: Mapping[str, Any],
        safety: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(kind, url, options)
        file = device_file(kind, options)
        place = Location("safety", 0, 0)
        self.safety = read_form(SafetyForm, plain_node(safety or {}, place), "'safety'").given()
        self.file = replace(file, limits=file.limits.tightened(self.safety))
        own, now = asdict(file.limits), asdict(self.file.limits)
        self.tightened = [name for name in own if now[name] != own[name]]
        """Limits that the scenario's ``safety`` made tighter than the device's own."""
        self.device: Device | None = None
        self._owner = 0
        """The process that opened the device; it alone closes the port."""
        self.flags = Flag.NONE

    @property
    def variables(self) -> Sequence[Variable]:
        """Exactly the pantograph FMU's."""
        return variables()

    @property
    def terminals(self) -> Mapping[str, Mapping[str, str]]:
        """Exactly the pantograph FMU's."""
        return terminals()

    @property
    def dependencies(self) -> Mapping[str, Sequence[str]]:
        """A device's outputs are measured; what was sent is known after ``write`` only."""
        return {}

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Configure, home, and see the handle rest; the first tick activates the device.

        Raises:
            DeviceError: the device does not answer.
            InputError: its address or file cannot be used.
        """
        self._command = inputs["motor_torque"]
        self._ignored = [
            inputs[v.name]
            for v in variables()
            if v.causality == "input" and v.role is Role.SIMULATION_ONLY
        ]
        self._angle, self._count = outputs["joint_angle"], outputs["encoder_count"]
        self._age, self._status = outputs["sample_age"], outputs["status"]
        self._applied = outputs["applied_torque"]
        for variable in variables():
            if variable.causality == "output" and variable.role is Role.SIMULATION_ONLY:
                outputs[variable.name][...] = nan if variable.type.is_float else 0
        if self.device is None:
            if not (self.kind.in_process or self.lockstep):
                raise InputError(
                    f"{setup.name} is a real device ({self.address.url}): run it with --realtime"
                )
            control = Fraction(*setup.tick) * setup.period
            self.open(Opening(name=setup.name, number=0, tick=control, parameters=setup.parameters))
        device = self._opened()
        observe_rest(device)
        self._started = False
        self._show(device.read(-1))
        self._applied[...] = 0.0

    def ask(self) -> None:
        """Ask what has to be asked before the device is opened where nobody can be."""
        sessions.current().ask_ahead(self._made(None))

    def rehearse(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Show the device file's home pose, as if the handle were held there; nothing is opened."""
        home = self.file.home
        if home is not None:
            outputs["joint_angle"][:] = home

    def open(self, opening: Opening) -> Device:
        """Configure and home the device: all that needs a person, a thread or the time to wait."""
        session = sessions.current()
        device = self._made(opening)
        device.configure()
        try:
            device.permission = session.permission(device)
            prove_at_opening(device)
            session.keep_awake(device)
            for warning in warnings_of(device):
                session.tell(warning)
            session.hold_home_pose(device)
            device.home()
        except BaseException:
            device.close()
            raise
        self.device, self._owner = device, os.getpid()
        return device

    def _made(self, opening: Opening | None) -> Device:
        if opening is None:
            return Device(self.kind, self.address, self.file)
        return Device(
            self.kind,
            self.address,
            self.file,
            tick=opening.tick,
            pulse=opening.pulse,
            # In lock-step time is counted in exchanges.
            clock=None if self.lockstep else opening.clock,
            number=opening.number,
            parameters=_changed(opening.parameters),
            alarm=sessions.current().alarm,
        )

    def read(self, tick: int) -> None:
        """Take the measurement; at the first tick the device becomes active.

        Not earlier: an active device has to be commanded every tick, and another one may still be
        waiting to come to rest.
        """
        device = self._opened()
        if not self._started:
            device.activate()
            begin_emulated_motion(device.address)
            self._started = True
        self._show(device.read(tick))

    def _show(self, measured: Measurement) -> None:
        self._angle[0], self._angle[1] = measured.joint_angle
        self._count[0], self._count[1] = measured.count
        self._age[0] = measured.sample_age
        self._status[0] = int(measured.status)

    def write(self, tick: int) -> None:
        """Send the command; a fault ends the run as soon as its outcome is known.

        Raises:
            DeviceFault: the device is in FAULT.
        """
        device = self._opened()
        sent = device.write(tick, (float(self._command[0]), float(self._command[1])))
        self._applied[0], self._applied[1] = sent.torque
        self._status[0] = int(device.status)
        self.flags = sent.flags
        if any(cells.any() for cells in self._ignored):
            self.flags |= Flag.IGNORED_INPUT
        device.raise_fault()

    def close(self) -> None:
        """Zero the device; let go of it where it was opened here, and nobody else has it."""
        if self.device is None:
            return
        if self._owner == os.getpid():
            self.device.close()
            self.device = None
            sessions.current().wakefulness.let_go()
        else:
            self.device.settle_down()

    def _opened(self) -> Device:
        assert self.device is not None, "initialise comes first"
        return self.device


def device_file(kind: type[Driver], options: Mapping[str, Any]) -> DeviceFile:
    """The device file that a scenario's options name, or the maker's defaults.

    Raises:
        InputError: it cannot be used, or belongs to another driver.
    """
    path = options.get("file")
    if path is not None and "preset" in options:
        raise InputError(f"'preset' has no effect beside 'file': write it into {path}")
    if path is None:
        preset = options.get("preset")
        return default(kind.driver, None if preset is None else str(preset))
    file = load(Path(str(path)).expanduser())
    if file.driver != kind.driver:
        raise InputError(f"{path} is a device file for '{file.driver}', not for '{kind.driver}'")
    return file


def observe_rest(device: Device) -> None:
    """Exchange zeros for long enough to know whether the handle rests."""
    for tick in range(-device.rest_ticks, 0):
        device.read(tick)
        device.write(tick, (0.0, 0.0))
        if device.state is State.FAULT and device.settled:
            break
        device.driver.pause()
    device.raise_fault()


def _changed(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters that a scenario set to something else than the model's default."""
    default = {variable.name: variable.start for variable in variables()}
    return {name: value for name, value in parameters.items() if value != default.get(name)}
