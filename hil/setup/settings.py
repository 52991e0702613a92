"""What a device file's ``settings`` hold for one driver alone: a form of the driver."""

from __future__ import annotations

from pydantic import create_model

from cosim.base.document.form import Form
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from hil.setup.device_form import DeviceFileForm


class DriverSettings(Form):
    """Base of every driver's settings; a driver without any takes this one."""


def form_with_settings(driver: str | None, problems: Problems) -> type[DeviceFileForm]:
    """The form of a device file for a driver, whose settings it has; an unknown one is reported."""
    from hil.setup.registry import find  # it needs the base of all devices, which needs this

    if driver is None:
        return DeviceFileForm
    try:
        settings = find(driver).settings
    except InputError as error:
        problems.add(("driver",), error.message)
        return DeviceFileForm
    return create_model("DeviceFileForm", __base__=DeviceFileForm, settings=(settings, settings()))
