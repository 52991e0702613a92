"""What has to stand behind a device before it may produce force."""

from __future__ import annotations

import threading
from typing import Any, Protocol

from hil.device.contract import LONGEST_WATCHDOG, Watchdog
from hil.device.errors import ActivationRefused
from hil.safety.limits import too_slow_to_drop
from hil.safety.permission import Permission
from hil.setup.address import DeviceAddress

NETWORK = frozenset({"socket", "rfc2217", "udp_multicast"})
"""Transports that anybody on the network could write to: for emulators only."""


class Guarded(Protocol):
    """A device as far as its safeguards go."""

    @property
    def permission(self) -> Permission | None:
        """Who let torque out, and how."""
        ...

    @property
    def name(self) -> str:
        """What sentences call it."""
        ...

    @property
    def tick(self) -> float:
        """The control period (s)."""
        ...

    @property
    def in_process(self) -> bool:
        """Whether nothing real is behind it."""
        ...

    @property
    def lockstep(self) -> bool:
        """Whether its emulator waits for it."""
        ...

    @property
    def address(self) -> DeviceAddress:
        """Where it is."""
        ...

    @property
    def watchdog(self) -> Watchdog:
        """What its board does when it hears nothing."""
        ...

    @property
    def file(self) -> Any:
        """Its device file."""
        ...

    @property
    def driver(self) -> Any:
        """Its driver."""
        ...


def check_safeguards(device: Guarded) -> None:
    """Refuse output that nothing would switch off when this process dies.

    Raises:
        ActivationRefused: a network transport to hardware, another Python thread in the process, no
            verified watchdog and no supervisor (or none that could take over), or no switch that
            cuts the power.
    """
    permission = device.permission
    if permission is None:
        return
    slow = too_slow_to_drop(device.tick)
    if slow is not None:
        raise ActivationRefused(f"{device.name} {slow}")
    if device.in_process:
        return
    emulated = permission.how.startswith("emulator")
    if device.address.transport in NETWORK and not emulated:
        raise ActivationRefused(
            f"{device.name} is reached over a network, which nobody guards: "
            "such a transport is for emulators only"
        )
    if threading.active_count() > 1 and not device.lockstep:
        raise ActivationRefused(
            f"{device.name}: another Python thread lives in the control process and would delay "
            "the loop by milliseconds"
        )
    watchdog = device.watchdog
    if watchdog.protects:
        return
    if not device.driver.shares_port:
        raise ActivationRefused(
            f"{device.name} is reached through its maker's library, whose handle no supervisor can "
            "take over, and its board has no watchdog that was seen to fire: it stays without "
            "output"
        )
    if emulated:
        return
    too_long = watchdog.timeout is not None and watchdog.timeout > LONGEST_WATCHDOG
    if watchdog.timeout is not None and not too_long:
        raise ActivationRefused(
            f"the watchdog of {device.name} has not been proved on this device: let it fire once "
            "with 'cohaptic device check URL --file FILE --enable-output'"
        )
    if device.driver.pulse is None:
        raise ActivationRefused(
            f"{device.name} has no verified watchdog and no supervisor guards this process: "
            "run it with --realtime"
        )
    if not device.file.estop_confirmed:
        raise ActivationRefused(
            f"{device.name} has {'a watchdog too slow to count' if too_long else 'no watchdog'}: "
            "its device file needs 'estop: confirmed', written by someone who has a switch that "
            "cuts the motors' power"
        )
