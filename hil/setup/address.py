"""Device URLs: ``driver[+transport]://place[?options]``.

``haply:///dev/ttyACM0``, ``haply+socket://localhost:9999``,
``odrive+socketcan://can0?nodes=0,1``, ``mock://``. The driver is what is registered under the entry
point group ``cohaptic.devices``; the transport belongs to pyserial or python-can.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import parse_qsl

from cosim.base.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceAddress:
    """A device URL taken apart; ``options`` also hold what the scenario's mapping adds."""

    url: str
    driver: str
    transport: str | None
    place: str
    options: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def serial_url(self) -> str:
        """What pyserial is given: a device path or name, or one of its own URLs."""
        return self.place if self.transport is None else f"{self.transport}://{self.place}"

    @property
    def is_lockstep(self) -> bool:
        """Whether it is an emulator that advances exactly as far as it is asked to."""
        return self.options.get("lockstep") == "1"

    @property
    def emulator(self) -> str | None:
        """The side channel of the emulator behind it, ``None`` for a real device."""
        return self.options.get("emulator")


def parse(url: str, options: Mapping[str, object] | None = None) -> DeviceAddress:
    """Take a device URL apart; the mapping's options win over the URL's.

    Raises:
        InputError: it has no scheme, or an option is given twice in it.
    """
    scheme, separator, rest = url.partition("://")
    if not (scheme and separator):
        raise InputError(
            f"'{url}' is no device URL: write driver://place, for example haply:///dev/ttyACM0 "
            "or mock://"
        )
    driver, _, transport = scheme.partition("+")
    place, _, query = rest.partition("?")
    found: dict[str, str] = {}
    for name, value in parse_qsl(query, keep_blank_values=True):
        if name in found:
            raise InputError(f"the device URL '{url}' gives '{name}' twice")
        found[name] = value
    found.update({name: _text(value) for name, value in (options or {}).items()})
    return DeviceAddress(
        url=url,
        driver=driver,
        transport=transport or None,
        place=place,
        options=found,
    )


def _text(value: object) -> str:
    if isinstance(value, bool):
        return "1" if value else "0"
    if isinstance(value, list | tuple):
        return ",".join(str(item) for item in value)  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
    return str(value)
