"""One CAN bus and all devices on it: sent together, one SYNC, collected until one deadline.

Any python-can interface. Whoever is read first in a tick collects for all; a silent node costs its
own data only. The load of a bus is computed before it is used, and an impossible one is refused.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from cosim.base.document.form import QuantityIn
from cosim.base.errors import InputError
from hil.device.errors import DeviceGone
from hil.emulation.side_channel import Control
from hil.setup.address import DeviceAddress
from hil.setup.options import UrlOptions, read_options
from hil.wire.ownership import OwnedNodes
from hil.wire.serial_port import (
    PATIENCE,
    QUIET_AFTER_DEATH,
    SETTLE_SECONDS,
    lockstep,
    settled_counts,
)

if TYPE_CHECKING:
    from cosim.base.system.pulse import Pulse

BUDGET_SECONDS = 600e-6
"""What all devices of a station may take of a tick."""
BITRATE = 1_000_000
LONGEST_BACKLOG = 2000
"""Frames taken in one go: more than a second of them are waiting, or they never stop coming."""
LARGEST_LOAD = 0.80
"""A bus that is fuller than this without stuffing, or full with it, cannot keep a deadline."""
_FRAME_BITS = 47
"""A classic data frame of 11-bit identifier without data: 44 bits and 3 between frames."""
_STUFFED_BITS = 34
"""Those of them that bit stuffing applies to (ISO 11898-1)."""


class CanOptions(UrlOptions):
    """Options of a device on a CAN bus."""

    bitrate: Annotated[
        int,
        QuantityIn(
            unit="1", what="bit rate, such as 1000000", least=10_000, most=8_000_000, whole=True
        ),
    ] = Field(default=BITRATE, description="Bits a second on the bus.")
    budget: Annotated[
        float, QuantityIn(unit="s", what="time, such as 0.0006 or '600 us'", above=0, most=600)
    ] = Field(default=BUDGET_SECONDS, description="What all its devices may take of a tick (s).")
    sleep_after_open: Annotated[
        float, QuantityIn(unit="s", what="time, such as 2", least=0, most=60)
    ] = Field(default=2.0, description="slcan: pause after opening (s).")


def frame_bits(size: int, *, stuffed: bool = False) -> int:
    """Bits of a classic frame with ``size`` data bytes; ``stuffed`` adds the worst case."""
    return _FRAME_BITS + 8 * size + ((_STUFFED_BITS + 8 * size - 1) // 4 if stuffed else 0)


@dataclass(frozen=True, slots=True)
class Load:
    """Share of a bus's time, without and with worst-case bit stuffing."""

    plain: float
    worst: float


def bus_load(sizes: Iterable[int], rate: float, bitrate: float = BITRATE) -> Load:
    """Load of the frames of one tick (data sizes in bytes) at a tick rate (Hz)."""
    frames = list(sizes)
    return Load(
        plain=sum(frame_bits(size) for size in frames) * rate / bitrate,
        worst=sum(frame_bits(size, stuffed=True) for size in frames) * rate / bitrate,
    )


def refuse_overload(name: str, sizes: Iterable[int], rate: float, bitrate: float) -> Load:
    """The load of a bus.

    Raises:
        InputError: the bus cannot carry it.
    """
    load = bus_load(sizes, rate, bitrate)
    if load.plain > LARGEST_LOAD or load.worst > 1.0:
        raise InputError(
            f"the CAN bus {name} cannot carry this: {load.plain:.1%} of its time at "
            f"{rate:g} Hz and {bitrate / 1e6:g} Mbit/s ({load.worst:.1%} with worst-case bit "
            f"stuffing), at most {LARGEST_LOAD:.0%} is sound; use a second bus, or a lower rate"
        )
    return load


_OPEN: dict[tuple[str, str], CanBus] = {}


@dataclass(eq=False)
class CanBus:
    """An open bus; ``open_bus`` shares it between the devices that name the same one."""

    name: str
    raw: Any
    key: tuple[str, str]
    bitrate: float
    budget: float
    pulse: Pulse | None = None
    reaches_others: bool = False
    """Whether other processes can be on it."""
    users: dict[object, tuple[int, ...]] = field(default_factory=dict[object, "tuple[int, ...]"])
    """Per device: the data sizes of its frames in one tick."""
    awaited: set[int] = field(default_factory=set[int])
    """Identifiers that every tick's collection waits for, up to the deadline."""
    begin_tick: Callable[[], None] | None = None
    """What opens a tick's collection: sending SYNC."""
    events: dict[int, list[bytes]] = field(default_factory=dict[int, "list[bytes]"])
    """Identifiers of which every frame matters, with those that nobody has taken yet."""
    extra: tuple[int, ...] = ()
    """Sizes of the frames that the bus itself sends in a tick (SYNC)."""
    sent: int = 0
    _received: int = 0
    _mine: set[int] = field(default_factory=set[int])
    _latest: dict[int, tuple[int, bytes]] = field(default_factory=dict[int, "tuple[int, bytes]"])
    _before: dict[int, int] = field(default_factory=dict[int, int])
    """How many frames of an identifier there were before this tick's SYNC."""
    _collected: set[object] = field(default_factory=set[object])
    _stepping: bool = False
    control: Control | None = None
    """The emulator's side channel, in lock-step."""

    def join(self, device: object, sizes: tuple[int, ...], rate: Fraction | float) -> None:
        """One more device with its frames of a tick.

        Raises:
            InputError: the bus cannot carry them all.
        """
        frames = [*self.extra, *(size for used in self.users.values() for size in used), *sizes]
        refuse_overload(self.name, frames, float(rate), self.bitrate)
        self.users[device] = sizes

    def own(self, nodes: Iterable[int]) -> OwnedNodes | None:
        """Have these nodes to oneself, where others could speak to them.

        Raises:
            DeviceError: another device has one of them.
        """
        return OwnedNodes(self.name, nodes) if self.reaches_others else None

    def leave(self, device: object) -> None:
        """One less; the last one closes the bus."""
        self.users.pop(device, None)
        self._collected.discard(device)
        if self.users:
            return
        _OPEN.pop(self.key, None)
        with contextlib.suppress(Exception):
            self.raw.shutdown()
        if self.control is not None:
            self.control.close()

    def keep_step(self) -> None:
        """From here on in lock-step with an emulator, where the URL says so."""
        self._stepping = self.control is not None

    def take_over(self) -> None:
        """Go on where a dead process left off."""
        if self.control is not None:
            self.control.close()
            self.control = Control(self.control.path)
            settled_counts(self.control, QUIET_AFTER_DEATH)
            self.resume()
        self._drain()

    def resume(self) -> None:
        """Go on after somebody else has used ``raw``: what came for them is no answer to us."""
        self._drain(SETTLE_SECONDS)
        self.count_from_here()

    def count_from_here(self) -> None:
        """Take over the emulator's counts; nothing may be under way."""
        if self.control is not None:
            state = self.control.ask("state")
            self.sent, self._received = int(state["received"]), int(state["written"])

    def send(self, identifier: int, data: bytes = b"", *, remote: bool = False) -> None:
        """Send a frame.

        Raises:
            DeviceGone: the bus does not take it.
        """
        import can

        message = can.Message(
            arbitration_id=identifier,
            data=data,
            is_extended_id=False,
            is_remote_frame=remote,
            check=False,
        )
        try:
            self.raw.send(message)
        except (can.CanError, OSError) as error:
            raise DeviceGone(f"the bus {self.name} does not take a frame: {error}") from error
        self.sent += 1
        self._mine.add(identifier)
        self._collected.clear()  # who writes has read: whoever reads next begins a tick

    def collect(self, device: object) -> None:
        """Have this tick's frames in ``latest``; the first device of a tick does the work."""
        if device not in self._collected and self._collected:
            self._collected.add(device)
            return
        if self.begin_tick is not None:
            # What is here by now answered an earlier SYNC, and does not say which.
            self._drain()
            self._before = {name: count for name, (count, _) in self._latest.items()}
            self.begin_tick()
        self._collected = {device}
        if self._stepping and self.control is not None:
            expected, end = self.control.sync(self.sent), time.monotonic() + PATIENCE
            late = False
            self._drain()
            while self._received < expected and not late:
                late = time.monotonic() > end
                self._drain(SETTLE_SECONDS)
            self._received = max(self._received, expected)  # what is not here by now was lost
            return
        missing = set(self.awaited)
        deadline = time.monotonic() + self.budget
        missing -= self._drain()
        while missing:
            left = deadline - time.monotonic()
            if left <= 0:
                return
            missing -= self._drain(left)

    def latest(self, identifier: int) -> tuple[int, bytes] | None:
        """The newest frame of an identifier: (how many came so far, data)."""
        return self._latest.get(identifier)

    def answer(self, identifier: int) -> bytes | None:
        """What answered this tick's SYNC under an identifier, ``None`` where nothing did."""
        count, data = self._latest.get(identifier, (0, b""))
        return data if count > self._before.get(identifier, 0) else None

    def taken(self, identifier: int) -> list[bytes]:
        """Every frame of an identifier in ``events`` since the last time."""
        frames, self.events[identifier] = self.events[identifier], []
        return frames

    def claim(self, identifiers: Iterable[int]) -> None:
        """Frames of these identifiers are our own, whoever sends them through ``raw``."""
        self._mine.update(identifiers)

    def _drain(self, wait: float = 0.0) -> set[int]:
        import can

        seen: set[int] = set()
        for _ in range(LONGEST_BACKLOG):
            try:
                message = self.raw.recv(wait)
            except (can.CanError, OSError, ValueError) as error:
                raise DeviceGone(f"the bus {self.name} is gone: {error}") from error
            if message is None:
                return seen
            wait = 0.0
            if message.is_remote_frame or message.is_extended_id or message.is_error_frame:
                continue
            identifier: int = message.arbitration_id
            if identifier in self._mine:
                continue  # udp_multicast hands a sender its own frames
            self._received += 1
            count = self._latest[identifier][0] + 1 if identifier in self._latest else 1
            self._latest[identifier] = (count, bytes(message.data))
            if identifier in self.events:
                self.events[identifier].append(bytes(message.data))
            seen.add(identifier)
        raise DeviceGone(
            f"the bus {self.name} brings frames faster than this machine reads them "
            f"({LONGEST_BACKLOG} in one go)"
        )


def open_bus(address: DeviceAddress, pulse: Pulse | None = None) -> CanBus:
    """The bus that a device's URL names; opened once in a process.

    Raises:
        DeviceGone: it cannot be opened.
        InputError: the URL does not say which bus.
    """
    if address.transport is None or not address.place:
        raise InputError(
            f"'{address.url}' does not name a bus: write {address.driver}+INTERFACE://CHANNEL, "
            f"for example {address.driver}+socketcan://can0"
        )
    key = (address.transport, address.place)
    if key not in _OPEN:
        given = can_options(address)
        _OPEN[key] = CanBus(
            name=f"{address.transport}://{address.place}",
            raw=raw_bus(address),
            key=key,
            bitrate=given.bitrate,
            budget=given.budget,
            pulse=pulse,
            reaches_others=address.transport != "virtual",
            control=lockstep(address),
        )
        _OPEN[key].count_from_here()
    return _OPEN[key]


def can_options(address: DeviceAddress) -> CanOptions:
    """The bus's options in a device's URL.

    Raises:
        InputError: one cannot be, or has no effect on this kind of bus.
    """
    if "sleep_after_open" in address.options and address.transport != "slcan":
        raise InputError(
            f"the device URL {address.url}: 'sleep_after_open' is for slcan adapters; leave it out"
        )
    return read_options(CanOptions, address)


def raw_bus(address: DeviceAddress) -> Any:
    """A python-can bus of its own for an address.

    Raises:
        DeviceGone: it cannot be opened.
    """
    import can

    try:
        if address.transport == "slcan":
            from hil.wire.slcan import StrictSlcanBus

            return StrictSlcanBus(**_options(address))
        return can.Bus(**_options(address))
    except (can.CanError, OSError, ValueError) as error:
        raise DeviceGone(f"the CAN bus of {address.url} cannot be opened: {error}") from error


def _options(address: DeviceAddress) -> Mapping[str, Any]:
    if address.transport == "udp_multicast":
        group, _, port = address.place.partition(":")
        return {
            "interface": "udp_multicast",
            "channel": group,
            "port": int(port or 43113),
            "hop_limit": 0,
        }
    given = can_options(address)
    options: dict[str, Any] = {
        "channel": address.place,
        "bitrate": given.bitrate,
    }
    if address.transport == "slcan":
        return {**options, "sleep_after_open": given.sleep_after_open}
    return {**options, "interface": address.transport}
