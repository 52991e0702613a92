"""What several device tests share: a body that a test moves by hand, and devices on it."""

from __future__ import annotations

from fractions import Fraction

from hil.device.contract import State
from hil.device.device import Device
from hil.drivers.mock.driver import MockDriver
from hil.safety.linkage import Linkage, Pair
from hil.safety.permission import Permission, emulated
from hil.setup.address import parse
from hil.setup.device_file import DeviceFile, default

TICK = Fraction(1, 1024)
QUANSER = Linkage(proximal=0.100, distal=0.165, base=0.085)
REST = (0.0425, 0.2)
REST_ANGLE = QUANSER.angles(REST)
ALLOWED: Permission = emulated("mock", None)


class Puppet:
    """A mechanism without dynamics: it is where the test puts it, and remembers its torques."""

    def __init__(self, angle: Pair = REST_ANGLE) -> None:
        self.place = angle
        self.torques: list[Pair] = []

    def angle(self) -> Pair:
        return self.place

    def step(self, torque: Pair) -> None:
        self.torques.append(torque)

    def start(self) -> None: ...

    def close(self) -> None: ...

    def put(self, tip: Pair) -> None:
        angles = QUANSER.angles(tip)
        assert angles is not None
        self.place = angles


def mock(
    puppet: Puppet, *, output: bool = True, file: DeviceFile | None = None, **options
) -> Device:
    """A mock device on a puppet; configured by the caller."""
    device = Device(
        MockDriver,
        parse("mock://"),
        file or default("mock"),
        tick=options.pop("tick", TICK),
        permission=ALLOWED if output else None,
        **options,
    )
    device.driver.body = puppet
    return device


def rested(device: Device, ticks: int = 40) -> Device:
    """Configured, homed and seen at rest: ready to be activated."""
    device.configure()
    device.home()
    for tick in range(-ticks, 0):
        device.read(tick)
        device.write(tick, (0.0, 0.0))
    assert device.state is State.INACTIVE
    return device


def run(device, ticks, command=(0.0, 0.0), start=0):
    """Exchange ``ticks`` times; the list of (measurement, sent)."""
    exchanged = []
    for tick in range(start, start + ticks):
        measured = device.read(tick)
        now = command(tick) if callable(command) else command
        exchanged.append((measured, device.write(tick, now)))
    return exchanged
