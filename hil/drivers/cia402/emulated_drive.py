"""A CiA 402 drive behind its object dictionary, as its maker sends it: nothing is set up yet.

State machine, option codes and timers are written here from the dictionary, without the driver's
functions; the reactions that it comes with brake, as many do.
"""

from __future__ import annotations

from math import pi
from typing import Any

from hil.drivers.canopen.emulated_local import Local, LocalWire
from hil.drivers.canopen.emulated_mapping import COMMUNICATION_ERROR, MappedNode
from hil.drivers.canopen.emulated_objects import I16, I32, LISTS, U8, U16, U32, dictionary_of
from hil.emulation.world import World

COUNTS = 20000
RATED = 200
"""mN.m."""
RAMP = 20
"""By how much a braking reaction takes the torque down in a tick (thousandths)."""
PROFILE, CYCLIC = 4, 10
DISABLED, READY, ON, ENABLED, QUICK, FAULT = 0x40, 0x21, 0x23, 0x27, 0x07, 0x08
I8 = 0x02
TIMEOUT = 0x8250
VARIABLES = (
    (0x1000, "Device type", U32, "ro", 0x0002_0192),
    (0x1001, "Error register", U8, "ro", 0),
    (0x1005, "COB-ID SYNC", U32, "rw", 0x80),
    (0x1017, "Producer heartbeat time", U16, "rw", 0),
    (0x6007, "Abort connection option", I16, "rw", 1),
    (0x6040, "Controlword", U16, "rw", 0),
    (0x6041, "Statusword", U16, "ro", DISABLED),
    (0x605A, "Quick stop option", I16, "rw", 2),
    (0x605B, "Shutdown option", I16, "rw", 1),
    (0x605C, "Disable operation option", I16, "rw", 1),
    (0x605D, "Halt option", I16, "rw", 1),
    (0x605E, "Fault reaction option", I16, "rw", 2),
    (0x6060, "Mode of operation", I8, "rw", 0),
    (0x6061, "Mode of operation display", I8, "ro", 0),
    (0x6064, "Position actual value", I32, "ro", 0),
    (0x6071, "Target torque", I16, "rw", 0),
    (0x6074, "Torque demand", I16, "ro", 0),
    (0x6076, "Rated torque", U32, "rw", RATED),
    (0x6087, "Torque slope", U32, "rw", 1000),
    (0x6502, "Supported drive modes", U32, "ro", 1 << PROFILE - 1 | 1 << CYCLIC - 1),
)
OWN_LISTS = (
    *(each for each in LISTS if each[0] < 0x2000),
    (0x608F, "Encoder resolution", "ro", [("Increments", U32, COUNTS), ("Turns", U32, 1)]),
)
PDOS = (
    (0x1400, 0x1600, "RPDO 1", 0x200, 255, (0x60400010, 0, 0)),
    (0x1800, 0x1A00, "TPDO 1", 0x180, 255, (0x60410010, 0, 0)),
    (0x1801, 0x1A01, "TPDO 2", 0x280, 255, (0x60410010, 0x60640020, 0)),
)
MAPPABLE = frozenset(
    {
        (0, 0, 0),
        (0x6040, 0, 16),
        (0x6041, 0, 16),
        (0x6064, 0, 32),
        (0x6071, 0, 16),
        (0x6074, 0, 16),
    }
)


class EmulatedDrive(MappedNode):
    """One drive at joint ``joint`` (0 or 1)."""

    mappable = MAPPABLE
    entries = 3

    def __init__(self, number: int, joint: int, wire: LocalWire, world: World) -> None:
        objects = dictionary_of(number, VARIABLES, OWN_LISTS, PDOS)
        super().__init__(number, Local(number, objects), wire)
        self._joint, self._world = joint, world
        self.state, self._demand, self._now = DISABLED, 0.0, 0.0
        self._commanded: float | None = None
        self._control = 0
        self.local.add_read_callback(self._read)
        self.local.add_write_callback(self._write)
        self.boot()

    def boot(self) -> None:
        """Start as after power-on: no torque, and all settings are the maker's."""
        self.state, self._demand, self._commanded, self._control = DISABLED, 0.0, None, 0
        super().boot()

    def take(self, data: bytes) -> None:
        """A command came, which its timer waits for."""
        if self.operational and not self.value(0x1400, 1) >> 31:
            self._commanded = self._now
        super().take(data)

    def listen(self, now: float) -> None:
        """Time passes: does the host command, is its heartbeat there; ramps go on."""
        self._now = now
        timer = self.value(0x1400, 5) * 1e-3
        if timer and self._commanded is not None and now - self._commanded > timer:
            self._commanded = None
            self.report(TIMEOUT, COMMUNICATION_ERROR)
        super().listen(now)
        if self.state != ENABLED and self._demand:
            left = max(0.0, abs(self._demand) - RAMP)
            self._demand = left if self._demand > 0 else -left

    def report(self, code: int, register: int) -> None:
        """An error: of the connection, whose option says what follows, or of the drive itself."""
        super().report(code, register)
        abort = self.value(0x6007, 0)
        if register != COMMUNICATION_ERROR or abort == 1:
            self._go(FAULT, 0x605E)
        elif abort == 2:
            self._off()
        elif abort == 3:
            self._go(QUICK, 0x605A)

    def drive(self) -> None:
        """Torque demand and statusword follow state, mode and target."""
        if self.state == ENABLED:
            target = self.value(0x6071, 0)
            step = self.value(0x6087, 0) / 1024 if self.value(0x6061, 0) == PROFILE else 1e9
            self._demand += max(-step, min(step, target - self._demand))
        self._show(0x6041, self.state | 0x0210)
        self._show(0x6074, round(self._demand))

    def torque(self) -> dict[int, float]:
        """What it makes its motor give."""
        return {self._joint: self._demand * 1e-3 * self.value(0x6076, 0) * 1e-3}

    def _show(self, index: int, value: int) -> None:
        self.local.set_data(index, 0, (value & 0xFFFF).to_bytes(2, "little"))

    def _off(self) -> None:
        self.state, self._demand = DISABLED, 0.0

    def _go(self, state: int, option: int | None = None) -> None:
        """Change state; a reaction other than 0 takes the torque down by a ramp."""
        if self.state == ENABLED and option is not None and self.value(option, 0) == 0:
            self._demand = 0.0
        self.state = state

    def _follow(self, control: int) -> None:
        """The state machine of CiA 402."""
        rises, self._control = control & ~self._control, control
        state, low = self.state, control & 0x0F
        if state == FAULT:
            if rises & 0x80:
                self.failed = False
                self.local.set_data(0x1001, 0, b"\0")
                self._off()
        elif not control & 0x02:
            self._off()
        elif not control & 0x04:
            if state == ENABLED and self.value(0x605A, 0):
                self._go(QUICK, 0x605A)
            elif state != QUICK:
                self._off()
        elif low == 0x06 and state in (DISABLED, ON, ENABLED):
            self._go(READY, 0x605B)
        elif low == 0x07 and state in (READY, ENABLED):
            self._go(ON, 0x605C)
        elif low == 0x0F and state == ON:
            self._go(ENABLED)

    def _read(self, index: int, subindex: int, **_: Any) -> int | None:
        if index != 0x6064:
            return None
        return round(self._world.angle()[self._joint] / (2 * pi) * COUNTS)

    def _write(self, index: int, subindex: int, data: bytes, **_: Any) -> None:
        if 0x1A00 <= index <= 0x1A01 or index == 0x1600:
            self._check_mapping(index, subindex, int.from_bytes(data, "little"))
        if index == 0x1016:
            self._heard = None
        if index == 0x1400 and subindex == 5:
            self._commanded = None
        if index == 0x6040:
            self._follow(int.from_bytes(data[:2], "little"))
        if index == 0x6060:
            self.local.set_data(0x6061, 0, data)
