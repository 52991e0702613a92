"""What a device file's ``settings`` hold for one driver alone; a sentence where it cannot be."""

from __future__ import annotations

from typing import cast

from cosim.base.errors import InputError
from cosim.base.show import show
from hil.setup.device_file import LARGEST, DeviceFile


def setting(file: DeviceFile, name: str, otherwise: float) -> float:
    """A setting that is one number.

    Raises:
        InputError: it is not.
    """
    value: object = file.settings.get(name, otherwise)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < LARGEST:
        raise InputError(
            f"'settings.{name}' of the device file has to be a number, not {show(value)}"
        )
    return float(value)


def pair_setting(file: DeviceFile, name: str, otherwise: tuple[int, int]) -> tuple[int, int]:
    """A setting that is a list of two whole numbers.

    Raises:
        InputError: it is not.
    """
    value: object = file.settings.get(name, otherwise)
    found = list(cast("list[object]", value)) if isinstance(value, list | tuple) else []
    if len(found) != 2 or not all(type(each) is int for each in found):
        raise InputError(
            f"'settings.{name}' of the device file has to be two whole numbers, for example "
            f"{list(otherwise)}, not {show(value)}"
        )
    first, second = cast("list[int]", found)
    return first, second
