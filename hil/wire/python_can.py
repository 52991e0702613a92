"""Any interface of python-can as a port: adapters, slcan, and what emulators use."""

from __future__ import annotations

import contextlib
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from typing import Any

from hil.device.errors import DeviceGone
from hil.setup.address import DeviceAddress
from hil.wire.can_options import can_options
from hil.wire.can_port import CanFrame, FrameKind


class PythonCanPort:
    """A python-can bus."""

    tells_sent = False

    def __init__(self, raw: Any) -> None:
        self.raw = raw

    def send(self, identifier: int, data: bytes, *, remote: bool) -> None:
        """Queue a frame."""
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
            raise DeviceGone(f"does not take a frame: {error}") from error

    def receive(self, wait: float) -> CanFrame | None:
        """The next frame, ``None`` where none comes within ``wait`` (s)."""
        import can

        try:
            message = self.raw.recv(wait)
        except (can.CanError, OSError, ValueError) as error:
            raise DeviceGone(f"is gone: {error}") from error
        if message is None:
            return None
        kind = FrameKind.DATA
        if message.is_error_frame:
            kind = FrameKind.ERROR
        elif message.is_remote_frame or message.is_extended_id:
            kind = FrameKind.OTHER
        return CanFrame(message.arbitration_id, bytes(message.data), kind)

    @contextmanager
    def for_set_up(self) -> Generator[Any]:
        """The bus itself; it stays open."""
        yield self.raw

    def close(self) -> None:
        """Let go of it."""
        with contextlib.suppress(Exception):
            self.raw.shutdown()


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
