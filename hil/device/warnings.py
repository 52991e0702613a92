"""What a person has to know before a device produces force."""

from __future__ import annotations

from hil.device.contract import CUT_POWER
from hil.device.device import Device


def warnings_of(device: Device) -> list[str]:
    """Sentences, for a device that is about to be allowed to push."""
    texts: list[str] = []
    if not device.watchdog.protects and not device.in_process:
        none = device.watchdog.timeout is None
        texts.append(
            f"{device.name} has {'no watchdog' if none else 'a watchdog that was never proved'}: "
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
