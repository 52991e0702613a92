"""Permission to let a device produce torque; without one, output is dry: computed but not sent.

A permission is made by one of the functions below and by nothing else, and says how it was given,
which goes into the record. ``--yes`` does for an emulator that proved itself one, never for
hardware.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hil.device.errors import ActivationRefused

_SEAL = object()
WORD = "enable"
"""What a person types at the prompt; a bare Enter confirms nothing."""


@dataclass(frozen=True, slots=True)
class Permission:
    """Output was asked for and confirmed."""

    how: str
    seal: object = None
    is_held: Callable[[], bool] | None = None
    """The dead-man input that it depends on, asked at every tick; ``None``: on none."""

    def __post_init__(self) -> None:
        if self.seal is not _SEAL:
            message = "a Permission is only made by hil.safety.permission's functions"
            raise TypeError(message)


def ask(device: str, warnings: list[str], prompt: Callable[[str], str]) -> Permission:
    """Ask a person.

    Raises:
        ActivationRefused: the answer was anything but the word asked for.
    """
    text = "\n".join([*warnings, f"{device} will produce force. Type '{WORD}' to let it: "])
    if prompt(text).strip() != WORD:
        raise ActivationRefused(f"{device} stays without output: it was not confirmed")
    return Permission("confirmed at the prompt", _SEAL)


def dead_man(
    device: str, is_held: Callable[[], bool], given: Permission | None = None
) -> Permission:
    """Take a dead-man input that is held right now; the loop asks it at every tick.

    ``given`` is what was confirmed besides (that the device is an emulator).

    Raises:
        ActivationRefused: it is not held.
    """
    if not is_held():
        raise ActivationRefused(f"{device} stays without output: the dead-man input is not held")
    how = "dead-man input held" if given is None else f"{given.how}, dead-man input held"
    return Permission(how, _SEAL, is_held)


def emulated(device: str, doubt: str | None) -> Permission:
    """``--yes``: no person is asked, because no person is touched.

    ``doubt`` says why the device may not be an emulator, ``None`` when it proved to be one.

    Raises:
        ActivationRefused: there is doubt.
    """
    if doubt is not None:
        raise ActivationRefused(
            f"--yes is for emulators, and {device} did not prove itself one ({doubt}): "
            "leave --yes out and confirm at the prompt"
        )
    return Permission("emulator, proved", _SEAL)
