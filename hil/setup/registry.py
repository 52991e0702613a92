"""Drivers by name, found through the entry point group ``cohaptic.devices``.

A lab adds a driver of its own by declaring an entry point in its own package.
"""

from __future__ import annotations

from contextlib import suppress
from difflib import get_close_matches

from cosim.base.errors import InputError
from cosim.base.system.installed import registered
from hil.setup.driver_facts import DriverFacts
from hil.setup.preset import Preset

GROUP = "cohaptic.devices"


def names() -> list[str]:
    """Every registered driver, sorted."""
    return sorted({entry.name for entry in registered(GROUP)})


def find(name: str) -> type[DriverFacts]:
    """The driver's class, for what it declares.

    Raises:
        InputError: there is no driver of that name, or its package is missing something.
    """
    found = [entry for entry in registered(GROUP) if entry.name == name]
    if not found:
        close = get_close_matches(name, names(), 1)
        hint = f"did you mean '{close[0]}'?" if close else f"there are {', '.join(names())}"
        raise InputError(f"there is no device driver '{name}'; {hint}")
    try:
        kind: object = found[0].load()
    except ImportError as error:
        raise InputError(f"the device driver '{name}' cannot be loaded: {error}") from error
    if not (isinstance(kind, type) and issubclass(kind, DriverFacts)):
        raise InputError(
            f"the entry point '{name}' of {GROUP} is no subclass of hil.device.driver.Driver"
        )
    return kind


def find_preset(name: str, kind: type[DriverFacts]) -> Preset:
    """A published device, for a device file of the driver ``kind``.

    Raises:
        InputError: no installed driver brings one of that name.
    """
    if name in kind.presets:
        return kind.presets[name]
    found: dict[str, Preset] = {}
    for driver in sorted(names(), key=lambda each: each != name):
        with suppress(InputError):  # a broken package is told of by ``device list``
            found.update(find(driver).presets)
        if name in found:
            return found[name]
    close = get_close_matches(name, found, 1)
    hint = f"did you mean '{close[0]}'?" if close else f"there are {', '.join(sorted(found))}"
    raise InputError(f"there is no preset '{name}'; {hint}")
