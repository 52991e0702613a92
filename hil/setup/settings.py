"""What a device file's ``settings`` hold for one driver alone: a form of the driver."""

from __future__ import annotations

from pydantic import create_model

from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from hil.setup.device_form import DeviceFileForm
from hil.setup.registry import find


def form_with_settings(driver: str | None, problems: Problems) -> type[DeviceFileForm]:
    """The form of a device file for a driver, whose settings it has; an unknown one is reported."""
    if driver is None:
        return DeviceFileForm
    try:
        settings = find(driver).settings
    except InputError as error:
        problems.add(("driver",), error.message)
        return DeviceFileForm
    return create_model("DeviceFileForm", __base__=DeviceFileForm, settings=(settings, settings()))
