"""One CAN bus and all devices on it: sent together, one SYNC, collected until one deadline.

Any python-can interface. Whoever is read first in a tick collects for all; a silent node costs its
own data only. The load of a bus is computed before it is used, and an impossible one is refused.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from cosim.base.errors import InputError
from hil.device.errors import DeviceGone
from hil.setup.address import DeviceAddress
from hil.wire.can_errors import trouble
from hil.wire.can_load import refuse_overload
from hil.wire.can_options import can_options, refuse_other_options
from hil.wire.can_port import CanFrame, CanPort, FrameKind
from hil.wire.can_received import ReceivedFrames
from hil.wire.ownership import OwnedNodes
from hil.wire.python_can import PythonCanPort, raw_bus
from hil.wire.serial_port import (
    PATIENCE,
    QUIET_AFTER_DEATH,
    SETTLE_SECONDS,
    lockstep,
    settled_counts,
)
from hil.wire.side_channel import Control
from hil.wire.socketcan import SocketCanPort

if TYPE_CHECKING:
    from cosim.base.system.pulse import Pulse

LONGEST_BACKLOG = 2000
"""Frames taken in one go: more than a second of them are waiting, or they never stop coming."""
QUEUE_TICKS = 4
"""A frame that is not on the bus so many ticks later waits for somebody to acknowledge it, and
would leave as a stale torque once somebody does."""

_OPEN: dict[tuple[str, str], CanBus] = {}


@dataclass(eq=False)
class CanBus:
    """An open bus; ``open_bus`` shares it between the devices that name the same one."""

    name: str
    port: CanPort
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
    pipelined: bool = False
    """Whether a tick begins with the answers to the last one's SYNC, and waits for none."""
    extra: tuple[int, ...] = ()
    """Sizes of the frames that the bus itself sends in a tick (SYNC)."""
    sent: int = 0
    received: ReceivedFrames = field(default_factory=ReceivedFrames)
    _collected: set[object] = field(default_factory=set[object])
    _stepping: bool = False
    complaint: str | None = None
    """What the controller said of the bus since the last frame came."""
    _is_off: bool = False
    _on_the_bus: int = 0
    """Frames of ours that the kernel handed back."""
    _sent_before: deque[int] = field(default_factory=lambda: deque[int](maxlen=QUEUE_TICKS))
    """How many had been sent at the beginning of each of the last ticks."""
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
        self.port.close()
        if self.control is not None:
            self.control.close()

    def keep_step(self) -> None:
        """From here on in lock-step with an emulator, where the URL says so."""
        self._stepping = self.control is not None

    def take_over(self) -> None:
        """Go on where a dead process left off: what it had queued is no business of ours."""
        self._sent_before.clear()
        self._on_the_bus = self.sent
        if self.control is not None:
            self.control.close()
            self.control = Control(self.control.path)
            settled_counts(self.control, QUIET_AFTER_DEATH)
            self.resume()
        self._drain()
        self.received.sync += 1

    def resume(self) -> None:
        """Go on after somebody else has used the wire: what came for them is no answer to us."""
        self._drain(SETTLE_SECONDS)
        self.received.sync += 1
        self.count_from_here()

    def count_from_here(self) -> None:
        """Take over the emulator's counts; nothing may be under way."""
        if self.control is not None:
            state = self.control.ask("state")
            self.sent, self.received.count = int(state["received"]), int(state["written"])

    def send(self, identifier: int, data: bytes = b"", *, remote: bool = False) -> None:
        """Send a frame.

        Raises:
            DeviceGone: the bus does not take it.
        """
        try:
            self.port.send(identifier, data, remote=remote)
        except DeviceGone as error:
            raise DeviceGone(f"the bus {self.name} {error}{self._because}") from error
        self.sent += 1
        self.received.claim((identifier,))
        self._collected.clear()  # who writes has read: whoever reads next begins a tick

    def collect(self, device: object) -> None:
        """Have this tick's frames in ``received``; the first device of a tick does the work."""
        self._refuse_if_off()
        if device not in self._collected and self._collected:
            self._collected.add(device)
            return
        if self.begin_tick is not None and self.pipelined:
            self._collect_pipelined(self.begin_tick)
            self._collected = {device}
            self._refuse_queue()
            return
        if self.begin_tick is not None:
            # What is here by now answered an earlier SYNC, and does not say which.
            self._drain()
            self.received.sync += 1
            self.received.answered = self.received.sync
            self.begin_tick()
        self._collected = {device}
        self._refuse_queue()
        if self._stepping and self.control is not None:
            self._step(self.control)
            return
        deadline = time.monotonic() + self.budget
        missing = self.awaited - self._drain()
        while missing:
            left = deadline - time.monotonic()
            if left <= 0:
                return
            missing -= self._drain(left)

    def _collect_pipelined(self, begin_tick: Callable[[], None]) -> None:
        """What came since the last SYNC answers it; then the next one."""
        if self._stepping and self.control is not None:
            self._step(self.control)
        else:
            self._drain()
        self.received.answered = self.received.sync
        self.received.sync += 1
        begin_tick()

    def _step(self, control: Control) -> None:
        """In lock-step: let the emulator deal with all that was sent, and take what it says."""
        expected, end = control.sync(self.sent), time.monotonic() + PATIENCE
        received, late = self.received, False
        self._drain()
        while received.count < expected and not late:
            late = time.monotonic() > end
            self._drain(SETTLE_SECONDS)
        received.count = max(received.count, expected)  # what is not here by now was lost

    def for_set_up(self) -> AbstractContextManager[Any]:
        """A python-can bus on the same wire, while nobody else uses it."""
        return self.port.for_set_up()

    @property
    def _because(self) -> str:
        return "" if self.complaint is None else f"; {self.complaint}"

    def _drain(self, wait: float = 0.0) -> set[int]:
        seen: set[int] = set()
        for _ in range(LONGEST_BACKLOG):
            try:
                frame = self.port.receive(wait)
            except DeviceGone as error:
                raise DeviceGone(f"the bus {self.name} {error}{self._because}") from error
            if frame is None:
                return seen
            wait = 0.0
            if self._take(frame):
                seen.add(frame.identifier)
        raise DeviceGone(
            f"the bus {self.name} brings frames faster than this machine reads them "
            f"({LONGEST_BACKLOG} in one go)"
        )

    def _take(self, frame: CanFrame) -> bool:
        """Whether it is a data frame of somebody else's."""
        if frame.kind is not FrameKind.DATA:
            self._take_other(frame)
            return False
        if not self.received.take(frame.identifier, frame.data):
            return False
        self.complaint = None
        return True

    def _take_other(self, frame: CanFrame) -> None:
        if frame.kind is FrameKind.SENT:
            self._on_the_bus += 1
        elif frame.kind is FrameKind.ERROR:
            found = trouble(frame.identifier, frame.data)
            self.complaint, self._is_off = found.said, found.is_off
            self._refuse_if_off()

    def _refuse_if_off(self) -> None:
        if self._is_off:
            raise DeviceGone(f"the bus {self.name} is gone{self._because}")

    def _refuse_queue(self) -> None:
        """What was sent some ticks ago has to have been on the bus by now."""
        if not self.port.tells_sent:
            return
        if len(self._sent_before) == QUEUE_TICKS and self._on_the_bus < self._sent_before[0]:
            waiting = self.sent - self._on_the_bus
            raise DeviceGone(
                f"{waiting} frames wait in the queue of {self.name} for {QUEUE_TICKS} ticks and "
                f"more: nobody acknowledges them{self._because}"
            )
        self._sent_before.append(self.sent)


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
    key, given = (address.transport, address.place), can_options(address)
    if key in _OPEN:
        refuse_other_options(_OPEN[key].bitrate, _OPEN[key].budget, address)
    else:
        _OPEN[key] = CanBus(
            name=f"{address.transport}://{address.place}",
            port=_port(address),
            key=key,
            bitrate=given.bitrate,
            budget=given.budget,
            pulse=pulse,
            reaches_others=address.transport != "virtual",
            control=lockstep(address),
        )
        _OPEN[key].count_from_here()
    return _OPEN[key]


def _port(address: DeviceAddress) -> CanPort:
    if address.transport == "socketcan":
        return SocketCanPort(address.place)
    return PythonCanPort(raw_bus(address))
