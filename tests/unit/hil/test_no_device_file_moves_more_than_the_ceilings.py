"""Whatever a device file says: refused, or no torque on the wire is beyond the hard ceilings.

Fuzzed files configure a device whose driver speaks to motors that read the wire by themselves,
apart from the product's emulators; it is then asked for all it can give.
"""

from __future__ import annotations

import itertools
import random
from collections import Counter
from fractions import Fraction
from typing import Any

import pytest

from cosim.base.errors import CohapticError, InputError
from hil.device.device import Device
from hil.device.driver import find_driver
from hil.safety.limits import Limits
from hil.safety.permission import emulated
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from tests.support.hil.motors.cobs import Cobs
from tests.support.hil.motors.haply import Haply
from tests.support.hil.motors.told import Motors

CEILING = 4 * Limits().torque
SLEW = 4 * Limits().slew
TICK = Fraction(1, 1024)
HOME = {"haply": [2.427, 0.714], "cobs": [2.2896, 0.852]}
FILES = 150


class Wire:
    """A serial port whose other end are independent motors in this very process."""

    def __init__(self, motors: Motors) -> None:
        self.motors = motors
        self.answers = b""
        self.torques: list[tuple[float, ...]] = []

    def write(self, frame: bytes) -> None:
        for told in self.motors.feed(frame):
            self.torques += [] if told.torques is None else [told.torques]
            self.answers += told.answer

    def read(self, most: int = 4096) -> bytes:
        data, self.answers = self.answers[:most], self.answers[most:]
        return data

    def wait(self, count: int, seconds: float) -> bytes:
        return self.read(count)

    def exchange_done(self) -> None: ...

    def close(self) -> None: ...


def number(draw: random.Random, usual: float) -> float:
    """Near what is usual, some times as much or as little, powers of ten off, or anything."""
    kind = draw.random()
    if kind < 0.6:
        return usual * draw.uniform(0.7, 1.4)
    if kind < 0.92:
        return usual * 10 ** draw.uniform(-1.2, 1.2)
    if kind < 0.98:
        return usual * 10 ** draw.uniform(-6, 6) * draw.choice((1, 1, -1))
    return draw.choice((0, 1, -1, 1e300, 5e-324, float("inf"), float("nan"), 1e9))


def some(draw: random.Random, values: dict[str, float], share: float = 0.4) -> dict[str, Any]:
    return {name: number(draw, usual) for name, usual in values.items() if draw.random() < share}


def document(draw: random.Random, driver: str) -> dict[str, Any]:
    limits = some(draw, {name: getattr(Limits(), name) for name in Limits.__slots__}, 0.2)
    made: dict[str, Any] = {
        "driver": driver,
        "home": HOME[driver],
        "limits": limits,
        "loosened": {name: "fuzzed" for name in limits if draw.random() < 0.95},
        "motor": some(draw, {"peak_torque": 5.0, "continuous_torque": 5.0}, 0.7),
        "joints": [
            {
                "direction": draw.choice((1, -1)),
                "drive": {"direction": draw.choice((1, -1)), **some(draw, {"gear": 1.5}, 0.3)},
            }
            for _ in range(2)
        ],
    }
    if draw.random() < 0.1:
        made["geometry"] = some(draw, {"proximal": 0.1, "distal": 0.165, "base": 0.085})
    if draw.random() < 0.1:
        made["workspace"] = some(draw, {"left": -0.1, "right": 0.2, "bottom": 0.1, "top": 0.25}, 1)
    return made


def torques_of(driver: str, values: dict[str, Any]) -> list[tuple[float, ...]] | None:
    """What goes out for all that can be asked; ``None`` for a file that is refused."""
    try:
        file = parse_file(values)
    except InputError:
        return None
    wire = Wire({"haply": Haply, "cobs": Cobs}[driver]())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(f"hil.drivers.{driver}.driver.SerialPort", lambda *_: wire)
        device = Device(
            find_driver(driver),
            parse(f"{driver}:///dev/none?lockstep=1"),
            file,
            tick=TICK,
            permission=emulated("a wire", None),
        )
        device.configure()
        device.home()
        for tick in range(-40, 0):
            device.read(tick)
            device.write(tick, (0.0, 0.0))
        try:
            device.activate()
        except CohapticError:
            return wire.torques
        for tick in range(2200):
            device.read(tick)
            device.write(tick, (1e3, -1e3) if tick else (0.0, 0.0))
        device.close()
    return wire.torques


@pytest.mark.parametrize("driver", ["haply", "cobs"])
def test_no_fuzzed_file_moves_more_than_the_hard_ceilings(driver):
    draw = random.Random(f"device files of {driver}")
    seen: Counter[str] = Counter()
    largest = 0.0
    for _ in range(FILES):
        values = document(draw, driver)
        torques = torques_of(driver, values)
        if torques is None:
            seen["refused"] += 1
            continue
        top = max(abs(torque) for pair in torques for torque in pair)
        assert top <= CEILING, values
        for axis in (0, 1):
            for before, after in itertools.pairwise(torques):
                grown = abs(after[axis]) - abs(before[axis])
                assert grown <= SLEW * float(TICK) * (1 + 1e-6), values
        assert torques[-1] == (0.0, 0.0), values
        seen["pushed" if top > 0.0 else "still"] += 1
        largest = max(largest, top)
    assert seen["refused"] > FILES // 4, seen
    assert seen["pushed"] > FILES // 20, seen
    assert largest > Limits().torque, "no file came near the ceilings"


def test_the_files_that_pushed_once_are_refused():
    slip = {"driver": "cobs", "home": HOME["cobs"], "joints": [{"drive": {"gear": 0.001}}, {}]}
    assert torques_of("cobs", slip) is None
    volts = [{"drive": {"torque_constant": 36.4e-6, "amplifier": 0.5}}, {}]
    with pytest.raises(InputError, match="torque_constant"):
        parse_file({"driver": "quanser", "joints": volts})
