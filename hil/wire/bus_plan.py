"""Before anything is opened: which CAN buses a scenario needs, and whether they can carry it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from cosim.base.errors import InputError
from hil.device.component import DeviceComponent
from hil.device.contract import BusUse
from hil.wire.can_load import Load, refuse_overload
from hil.wire.can_options import can_options


@dataclass(slots=True)
class PlannedBus:
    """One bus with the devices on it; ``rate`` (Hz) is the fastest one's."""

    name: str
    bitrate: float
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


def plan_buses(devices: Mapping[str, tuple[DeviceComponent, Fraction]]) -> list[PlannedBus]:
    """The buses of a scenario's devices, each given with its control rate (Hz)."""
    buses: dict[tuple[str | None, str], PlannedBus] = {}
    for name, (component, rate) in devices.items():
        address = component.address
        use = component.kind.bus_use(address, component.file)
        if use is None:
            continue
        key = (address.transport, address.place)
        bus = buses.setdefault(
            key,
            PlannedBus(
                f"{address.transport}://{address.place}",
                can_options(address).bitrate,
                rate,
            ),
        )
        bus.rate = max(bus.rate, rate)
        bus.users[name] = use
    return list(buses.values())
