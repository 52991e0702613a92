"""What a person has to know before a device produces force."""

from __future__ import annotations

from hil.device.contract import CUT_POWER, LONGEST_WATCHDOG
from hil.device.device import Device


def warnings_of(device: Device) -> list[str]:
    """Sentences, for a device that is about to be allowed to push."""
    texts: list[str] = []
    timeout = device.watchdog.timeout
    # One that is fast enough has to fire before there is any force.
    if not device.in_process and (timeout is None or timeout > LONGEST_WATCHDOG):
        texts.append(
            f"{device.name} has {'no watchdog' if timeout is None else 'too slow a watchdog'}: "
            "when it is unplugged, hangs or runs away its output is unknown; "
            f"{CUT_POWER.split(':')[0]} then. Keep the switch within reach."
        )
    texts += [
        f"{device.name}: {_loosened(device, name)}: {reason}"
        for name, reason in device.file.loosened.items()
    ]
    if not (device.driver.tested_on_hardware or device.in_process):
        texts.append(f"the driver '{device.driver.driver}' has met emulators only, never hardware")
    return texts


def _loosened(device: Device, name: str) -> str:
    if name == "workspace":
        return "the workspace reaches beyond the default"
    return f"the limit '{name}' is loosened to {getattr(device.file.limits, name):g}"
