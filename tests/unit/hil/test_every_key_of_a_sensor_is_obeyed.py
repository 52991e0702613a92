"""Changing any key of a sensor's file changes what it measures, or whether it is opened at all."""

from __future__ import annotations

from typing import Any

import pytest

from cosim.base.errors import CohapticError
from hil.sensing.reading import Heard
from hil.sensing.sensor import Sensor
from hil.sensing.sensor_driver import SensorDriver
from hil.sensing.sensor_file import SensorFileForm
from hil.sensing.sensor_file import parse as parse_file
from hil.setup.address import parse
from hil.setup.registry import find, names
from tests.support.forms.walk import keys_of

SENSORS = [kind for name in names() if (kind := find(name)).measures_only]
CHANNEL = {"force": [0.01, 0, 0], "full_scale": 1000}


class Bench(SensorDriver):
    """A board whose counts are 100 in every channel, and which is another day's."""

    driver = "force_sensor"
    known = SENSORS[0].known

    def open(self) -> None:
        self._time = 0.0

    def ask(self) -> None:
        self._time += self.tick

    def receive(self) -> Heard:
        counts = tuple(100 for _ in self.file.channels)
        return Heard(counts=counts, device_time=self._time)

    def pause(self) -> None: ...

    def close(self) -> None: ...

    def serial(self) -> str:
        return "7"


def measured(document: dict[str, Any]) -> str:
    """What comes of a file: the wrench under 100 counts, or why there is none."""
    document = {"driver": "force_sensor", "settings": {"channels": [CHANNEL]}, **document}
    try:
        file = parse_file(document, Bench.known, "six_axis")
        with Sensor(Bench, parse("force_sensor://x"), file) as sensor:
            sensor.configure()
            return f"{sensor.wrench} {sensor._zeros} {file.date} {file.driver}"
    except CohapticError as error:
        return str(error)


def channel(**values: Any) -> dict[str, Any]:
    return {"settings": {"channels": [{**CHANNEL, **values}]}}


CASES: dict[tuple[str, str], tuple[dict[str, Any], dict[str, Any]]] = {
    ("SensorFileForm", "driver"): ({}, {"driver": "cobs"}),
    ("SensorFileForm", "preset"): (
        {"settings": {}, "preset": "six_axis"},
        {"settings": {}, "preset": "load_cell_50n"},
    ),
    ("SensorFileForm", "serial"): ({"serial": "7"}, {"serial": "8"}),
    ("SensorFileForm", "date"): ({}, {"date": "2026-11-27"}),
    ("SensorFileForm", "settings"): ({}, {"settings": {"tare": False}}),
    ("SensorSettings", "channels"): ({}, {"settings": {"channels": [CHANNEL, CHANNEL]}}),
    ("SensorSettings", "tare"): ({}, {"settings": {"channels": [CHANNEL], "tare": False}}),
    ("LoadChannelForm", "force"): ({}, channel(force=[0, 0.01, 0])),
    ("LoadChannelForm", "torque"): ({}, channel(torque=[0, 0.01, 0])),
    ("LoadChannelForm", "zero"): ({}, channel(zero=500)),
    ("LoadChannelForm", "full_scale"): ({}, channel(full_scale=80)),
}


def test_every_key_has_a_case() -> None:
    own = keys_of(SensorFileForm, *(kind.settings for kind in SENSORS))
    assert CASES.keys() == own


@pytest.mark.parametrize("key", sorted(CASES), ids=".".join)
def test_a_key_changes_what_is_measured(key) -> None:
    one, two = CASES[key]
    assert measured(one) == measured(one)
    assert measured(one) != measured(two)
