"""What a device and a sensor are to the supervisor: an address, names of states, a port."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from typing import Any, Generic, TypeVar

from cosim.base.component import Component
from hil.device.facts import CAUSES, STATES
from hil.setup.address import DeviceAddress, parse
from hil.setup.driver_facts import DriverFacts
from hil.setup.options import check_options
from hil.wire.side_channel import Control

D = TypeVar("D", bound=DriverFacts)
_FILE_OPTIONS = ("file", "preset")


class BoardComponent(Component, Generic[D]):
    """A board whose driver is of ``kind``.

    Raises:
        InputError: the URL, or an option of it, cannot be used.
    """

    def __init__(self, kind: type[D], url: str, options: Mapping[str, Any]) -> None:
        self.kind = kind
        self.address = address_of(url, options)
        check_options(kind.options, self.address)

    @property
    def lockstep(self) -> bool:
        """Whether it is an emulator that advances exactly as far as it is asked to."""
        return self.address.is_lockstep

    @property
    def states(self) -> Sequence[str]:
        """Names of the states of its life."""
        return STATES

    @property
    def causes(self) -> Sequence[str]:
        """Names of what can end in FAULT."""
        return CAUSES

    @property
    def shares_port(self) -> bool:
        """Whether other processes can go on with its open port."""
        return self.kind.shares_port


def address_of(url: str, options: Mapping[str, Any]) -> DeviceAddress:
    """The address that a scenario's mapping gives; its file and its preset are no part of it."""
    return parse(url, {name: value for name, value in options.items() if name not in _FILE_OPTIONS})


def begin_emulated_motion(address: DeviceAddress) -> None:
    """Tell an emulator that the run begins, so that its operator's time is the scenario's."""
    if address.emulator is not None:
        with closing(Control(address.emulator)) as control:
            control.ask("start")
