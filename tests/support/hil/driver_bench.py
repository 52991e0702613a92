"""A driver on its emulator: what the suite needs to know of each, and how to bring both up."""

from __future__ import annotations

import atexit
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hil.device.contract import ZERO, Measurement, Sent
from hil.device.device import Device
from hil.emulation.launch import Emulator, Order
from hil.firmware.build import build
from hil.safety.permission import emulated
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from hil.setup.registry import find

TICK = Fraction(1, 1024)
HAPLY = {"device": 1, "initial_tip_position": (0.019, 0.1)}
QUANSER = {"device": 0, "initial_tip_position": (0.0425, 0.2)}

PROOF = {"date": "2026-11-22", "timeout": 0.02, "fired_after": 0.03}
"""What ``device check`` leaves in the device file; test_the_watchdog_is_proved makes real ones."""

SETUPS: dict[str, dict[str, Any]] = {
    "haply": {"parameters": HAPLY, "file": {"preset": "haply"}, "serial": True, "frame": 10},
}

SETUPS["cobs"] = {
    "parameters": QUANSER,
    "file": {
        "joints": [{"counts_per_turn": 20000}, {"counts_per_turn": 20000}],
        "watchdog_proof": PROOF,
    },
    "serial": True,
    "frame": 18,
}
SETUPS["cobs (C firmware)"] = {
    **SETUPS["cobs"],
    "driver": "cobs",
    "emulator": "cobs",
    "firmware": True,
    "serial": False,
}
"""The C reference on the board's side of the pty; the host's side is the same, byte for byte."""
ODRIVE_WATCHDOG = {
    "timeout": 0.02,
    "timeout_endpoint": 0x0101,
    "enable_endpoint": 0x0102,
}
SETUPS["odrive"] = {
    "parameters": QUANSER,
    "file": {
        "joints": [{"counts_per_turn": 8192}, {"counts_per_turn": 8192}],
        "settings": {"watchdog": ODRIVE_WATCHDOG},
        "watchdog_proof": PROOF,
    },
}
SETUPS["odrive (slcan)"] = {**SETUPS["odrive"], "driver": "odrive", "emulator": "odrive"} | {
    "link": "slcan"
}
SETUPS["canopen"] = {"parameters": QUANSER, "file": {}}
SETUPS["canopen (slcan)"] = {**SETUPS["canopen"], "driver": "canopen", "emulator": "canopen"} | {
    "link": "slcan"
}
SETUPS["cia402"] = {"parameters": QUANSER, "file": {}}
SETUPS["cia402 (slcan)"] = {
    **SETUPS["cia402"],
    "driver": "cia402",
    "emulator": "cia402",
    "link": "slcan",
    "apart": True,
}
for name in ("canopen", "cia402"):
    SETUPS[f"{name} (pipelined)"] = SETUPS[name] | {
        "driver": name,
        "emulator": name,
        "url": "&pipelined=1",
        "apart": True,
    }
for nodes in ((1, 2), (1, 2, 3)):
    SETUPS[f"canopen ({len(nodes)} nodes)"] = SETUPS["canopen"] | {
        "driver": "canopen",
        "emulator": "canopen",
        "options": {"nodes": nodes},
        "apart": True,
    }
"""Per driver: the emulated pantograph's parameters, the device file, the emulator's options."""

DRIVERS = sorted(name for name, setup in SETUPS.items() if not setup.get("apart"))
"""Those that go through the whole suite."""


@cache
def firmware() -> str:
    """The C reference, compiled once for all tests."""
    folder = TemporaryDirectory(prefix="cohaptic-firmware-")
    atexit.register(folder.cleanup)
    return str(build(Path(folder.name)))


@dataclass
class Rig:
    """A device and the emulator behind it."""

    device: Device
    emulator: Emulator
    tick: int = 0

    def exchange(self, ticks: int, command=ZERO) -> list[tuple[Measurement, Sent]]:
        done = []
        for _ in range(ticks):
            measured = self.device.read(self.tick)
            wanted = command(self.tick, measured) if callable(command) else command
            done.append((measured, self.device.write(self.tick, wanted)))
            self.tick += 1
        return done

    def truth(self) -> dict[str, Any]:
        return self.emulator.control.ask("state")

    def fault(self, kind: str, **values: int) -> None:
        self.emulator.control.ask("fault", kind=kind, **values)


class Bench:
    """Everything that was started, to be closed."""

    def __init__(self) -> None:
        self._open: list[Any] = []

    def emulator(self, name: str, *, lockstep: bool = True, **changes: Any) -> Emulator:
        setup = SETUPS[name]
        options = dict(setup.get("options", {}))
        if "firmware" in setup:
            options["firmware"] = firmware()
        order = Order(
            name=setup.get("emulator", name),
            lockstep=lockstep,
            parameters=setup["parameters"],
            link=setup.get("link", "pty"),
            options=options,
            **changes,
        )
        emulator = Emulator(order)
        self._open.append(emulator)
        return emulator

    def device(
        self, name: str, emulator: Emulator, *, output: bool = True, file=None, **options
    ) -> Device:
        kind = find(SETUPS[name].get("driver", name))
        file = SETUPS[name]["file"] if file is None else file
        document = {"driver": kind.driver, "home": list(emulator.home), **file}
        url = emulator.url + SETUPS[name].get("url", "")
        device = Device(kind, parse(url), parse_file(document), tick=TICK, **options)
        if output:
            device.permission = emulated(emulator.url, None)
        self._open.append(device)
        return device

    def rig(self, name: str, *, activate=True, output=True, hand=None, **options) -> Rig:
        emulator = self.emulator(name, hand=hand or {})
        made = Rig(self.device(name, emulator, output=output, **options), emulator)
        made.device.configure()
        made.device.home()
        made.tick = -made.device.rest_ticks
        made.exchange(made.device.rest_ticks)
        if activate:
            made.device.activate()
        return made

    def close(self) -> None:
        for thing in reversed(self._open):
            with suppress(Exception):
                thing.close()
