"""All the motors by the name of the driver that speaks to them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from tests.support.hil.motors.canopen import Canopen
from tests.support.hil.motors.cia402 import Cia402
from tests.support.hil.motors.cobs import Cobs
from tests.support.hil.motors.haply import Haply
from tests.support.hil.motors.odrive import Odrive
from tests.support.hil.motors.told import Motors

BOARDS: Mapping[str, Callable[[], Motors]] = {
    "haply": Haply,
    "cobs": Cobs,
    "odrive": Odrive,
    "canopen": Canopen,
    "cia402": Cia402,
}
