"""The component that a device's URL stands for: a pantograph's place, or a sensor's outputs."""

from __future__ import annotations

from typing import Any

from cosim.base.component import Component
from hil.device.component import DeviceComponent
from hil.device.driver import find_driver
from hil.sensing.component import SensorComponent
from hil.sensing.sensor_driver import find_sensor
from hil.setup.registry import find


def open_component(url: str, options: dict[str, Any], safety: dict[str, Any]) -> Component:
    """The component that a scenario's ``device: URL`` stands for (entry point contract).

    ``safety`` are limits that the scenario puts on every device that pushes: the tighter ones hold.

    Raises:
        InputError: there is no such driver, or the URL or its options cannot be used.
    """
    name = url.partition("://")[0].partition("+")[0]
    if find(name).measures_only:
        return SensorComponent(find_sensor(name), url, options)
    return DeviceComponent(find_driver(name), url, options, safety)
