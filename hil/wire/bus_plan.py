"""Before anything is opened: which CAN buses a scenario needs, and whether they can carry it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from cosim.base.errors import InputError
from hil.device.component import DeviceComponent
from hil.device.contract import BusUse
from hil.sensing.component import SensorComponent
from hil.wire.can_load import Load, refuse_overload
from hil.wire.can_options import can_options, refuse_other_options

Placed = DeviceComponent | SensorComponent
"""What has a port, or nodes on a bus, to itself."""


@dataclass(slots=True)
class PlannedBus:
    """One bus with the devices on it; ``rate`` (Hz) is the fastest one's."""

    name: str
    bitrate: float
    budget: float
    rate: Fraction
    users: dict[str, BusUse] = field(default_factory=dict[str, BusUse])

    @property
    def sizes(self) -> list[int]:
        """Data bytes of every frame of one tick."""
        shared = next((use.shared for use in self.users.values() if use.shared), ())
        return [*shared, *(size for use in self.users.values() for size in use.frames)]

    def load(self) -> Load:
        """Share of the bus's time.

        Raises:
            InputError: it cannot carry this.
        """
        try:
            return refuse_overload(self.name, self.sizes, float(self.rate), self.bitrate)
        except InputError as error:
            raise InputError(f"{', '.join(self.users)}: {error.message}") from None


def plan_buses(devices: Mapping[str, tuple[Placed, Fraction]]) -> list[PlannedBus]:
    """The buses of a scenario's devices, each given with its control rate (Hz)."""
    buses: dict[tuple[str | None, str], PlannedBus] = {}
    for name, (component, rate) in devices.items():
        address = component.address
        use = _use(component)
        if use is None:
            continue
        key = (address.transport, address.place)
        bus = buses.setdefault(
            key,
            PlannedBus(
                f"{address.transport}://{address.place}",
                can_options(address).bitrate,
                can_options(address).budget,
                rate,
            ),
        )
        bus.rate = max(bus.rate, rate)
        bus.users[name] = use
    return list(buses.values())


def refuse_shared_place(name: str, devices: Mapping[str, tuple[Placed, Fraction]]) -> None:
    """Refuse a device that would share with an earlier one what one device has to itself.

    Raises:
        InputError: a port, a node, or a bus with another bit rate.
    """
    component, _ = devices[name]
    address = component.address
    use = _use(component)
    for other, (earlier, _) in devices.items():
        if other == name:
            return
        if (
            component.kind.in_process
            or earlier.kind.in_process
            or place(component) != place(earlier)
        ):
            continue
        before = _use(earlier)
        if use is None or before is None:
            raise InputError(
                f"{name} is at {address.place}, where {other} is already: give each a port of its "
                "own"
            )
        common = sorted(set(use.nodes) & set(before.nodes))
        if common:
            raise InputError(
                f"{name} has node {common[0]} on {address.transport}://{address.place}, which "
                f"{other} has already: give each nodes of its own"
            )
        options = can_options(earlier.address)
        refuse_other_options(options.bitrate, options.budget, address)


def place(component: Placed) -> tuple[str | None, str]:
    """Where a device is, by one name; a port may have several in the file system."""
    address = component.address
    if address.transport is None and address.place.startswith("/"):
        return None, str(Path(address.place).resolve())
    return address.transport or component.kind.driver, address.place


def _use(component: Placed) -> BusUse | None:
    """Its frames on a CAN bus."""
    if isinstance(component, SensorComponent):
        return component.kind.bus_use(component.address, component.file)
    return component.kind.bus_use(component.address, component.file)
