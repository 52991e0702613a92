"""A serial port as a driver uses it in the loop: never blocking, every byte accounted for."""

from __future__ import annotations

import contextlib
import os
import select
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from cosim.base.document.form import QuantityIn
from hil.device.errors import DeviceError, DeviceGone
from hil.setup.address import DeviceAddress
from hil.setup.options import UrlOptions, read_options
from hil.wire.ownership import own_port
from hil.wire.side_channel import Control

if TYPE_CHECKING:
    from cosim.base.system.pulse import Pulse

PATIENCE = 60.0
"""In lock-step: how long to wait for bytes that the emulator is known to have sent (s)."""
SETTLE_SECONDS = 0.01
QUIET_AFTER_DEATH = 5
"""Looks at an emulator's counts that have to agree before a dead process counts as silent."""
BAUD = 115200


class SerialOptions(UrlOptions):
    """Options of a device on a serial port."""

    baud: Annotated[
        int,
        QuantityIn(unit="1", what="baud rate, such as 115200", least=50, most=10**8, whole=True),
    ] = Field(default=BAUD, description="Bits a second on a UART; USB serial ignores it.")
    wait: Annotated[
        float, QuantityIn(unit="s", what="time, such as 2 or '1500 ms'", least=0, most=60)
    ] = Field(default=0.0, description="Pause for boards that reset as the port is opened (s).")


class SerialPort:
    """Any pyserial URL.

    With ``emulator=`` and ``lockstep=1`` in the device's URL, waiting means asking the emulator
    whether it has dealt with everything that was sent, so that nothing depends on a clock.
    """

    def __init__(self, address: DeviceAddress, pulse: Pulse | None = None, number: int = 0) -> None:
        import serial

        self._pulse, self._number = pulse, number
        self.sent = 0
        self.spoil: Callable[[bytes], bytes] | None = None
        """What becomes of a frame on its way, where a board is tried with damaged ones."""
        options = read_options(SerialOptions, address)
        try:
            self._port: Any = serial.serial_for_url(  # pyright: ignore[reportUnknownMemberType]
                address.serial_url, baudrate=options.baud, timeout=0, write_timeout=0
            )
        except (OSError, ValueError) as error:
            raise DeviceGone(f"the port {address.serial_url} cannot be opened: {error}") from error
        self._descriptor = _descriptor(self._port)
        if self._descriptor is not None:
            try:
                own_port(self._descriptor, address.serial_url)
            except DeviceError:
                self._port.close()
                raise
        if options.wait:
            wait_for_board(options.wait)
            self._port.reset_input_buffer()  # what it says as it starts
        self._poll = select.poll()
        if self._descriptor is not None:
            self._poll.register(self._descriptor, select.POLLIN)
        self._control = lockstep(address)
        self._received = self._expected = 0
        self._count_from_here()
        self.low_latency = False
        # A pty refuses it, USB adapters with a latency timer need it.
        with contextlib.suppress(Exception):
            self._port.set_low_latency_mode(True)
            self.low_latency = True

    def write(self, frame: bytes) -> None:
        """Send a whole frame, marked for the supervisor while it is under way.

        Raises:
            DeviceGone: the other end is closed, or takes no bytes.
        """
        if self.spoil is not None:
            frame = self.spoil(frame)
        if self._pulse is not None:
            self._pulse.begin(self._number, len(frame))
        done = 0
        try:
            while done < len(frame):
                count = self._write(frame[done:])
                done += count
                self.sent += count
                if self._pulse is not None:
                    self._pulse.progress(done)
        except OSError as error:
            raise DeviceGone(f"the port is gone: {error}") from error
        if self._pulse is not None:
            self._pulse.end()

    def _write(self, part: bytes) -> int:
        """Straight to the descriptor: pyserial would wait, or spin, where the line is full."""
        if self._descriptor is None:
            return int(self._port.write(part) or 0)
        try:
            return os.write(self._descriptor, part)
        except BlockingIOError as error:
            raise DeviceGone("the port takes no more bytes") from error

    def read(self, most: int = 4096) -> bytes:
        """What has arrived, at once.

        Raises:
            DeviceGone: the other end is closed.
        """
        data = self._read(most)
        self._received += len(data)
        end, late = time.monotonic() + PATIENCE, False
        while self._received < self._expected and len(data) < most and not late:
            late = time.monotonic() > end  # before the look: a process that slept looks once more
            more = self._read(most - len(data))
            self._received += len(more)
            data += more
        return data

    def _read(self, most: int) -> bytes:
        try:
            if self._descriptor is None:
                return bytes(self._port.read(most))
            return os.read(self._descriptor, most) or self._read_again(most)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise DeviceGone(f"the port is gone: {error}") from error

    def _read_again(self, most: int) -> bytes:
        """Nothing came: is there nothing, or is nobody there? Something may also have come now."""
        assert self._descriptor is not None
        events = self._poll.poll(0)
        if not events:
            return b""
        data = os.read(self._descriptor, most) if events[0][1] == select.POLLIN else b""
        if not data:
            raise DeviceGone("the port is gone: the other end was closed")
        return data

    def exchange_done(self) -> None:
        """In lock-step: let the emulator finish this tick. On a real port: nothing."""
        if self._control is not None:
            self._expected = self._control.sync(self.sent)

    def wait(self, count: int, seconds: float) -> bytes:
        """Read ``count`` bytes, or what has come by then (set-up and recovery, not the loop)."""
        self.exchange_done()
        end, data = time.monotonic() + seconds, b""
        while True:
            data += self.read(count - len(data))
            if len(data) >= count or time.monotonic() > end or self._control is not None:
                return data
            time.sleep(0.0005)

    def _count_from_here(self, quiet: int = 1) -> None:
        if self._control is not None:
            self.sent, self._expected = settled_counts(self._control, quiet)
            self._received = self._expected
            if self._descriptor is not None:
                self._port.reset_input_buffer()

    def take_over(self) -> None:
        """Go on where a dead process left off: drop what came for it, talk to nobody but us."""
        self._pulse = None
        if self._control is not None:
            self._control.close()
            self._control = Control(self._control.path)
            self._count_from_here(QUIET_AFTER_DEATH)
        self.read()

    def close(self) -> None:
        """Close the port; the other end may be gone already."""
        with contextlib.suppress(OSError):
            self._port.close()
        if self._control is not None:
            self._control.close()


def wait_for_board(seconds: float) -> None:
    """Give a board that was just reset the time (s) to start."""
    time.sleep(seconds)


def _descriptor(port: Any) -> int | None:
    try:
        return int(port.fileno())
    except (OSError, AttributeError):
        return None


def settled_counts(control: Control, quiet: int) -> tuple[int, int]:
    """What an emulator has received and sent, once that has stood still for ``quiet`` looks."""
    last, stood = (-1, -1), -1
    while stood < quiet:
        time.sleep(SETTLE_SECONDS)
        state = control.ask("state")
        counts = (int(state["received"]), int(state["written"]))
        stood, last = (stood + 1 if counts == last else 0), counts
    return last


def lockstep(address: DeviceAddress) -> Control | None:
    """The emulator's side channel where the URL asks for lock-step.

    Raises:
        DeviceError: lock-step without an emulator to be in step with.
    """
    if not address.is_lockstep:
        return None
    path = address.emulator
    if path is None:
        raise DeviceError("lockstep=1 needs emulator=PATH, the emulator's side channel")
    return Control(path)
