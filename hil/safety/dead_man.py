"""A dead-man input: force lasts as long as a person holds it, asked at every tick.

Two sources. ``device``: a switch wired to the board itself, in every answer of it (``cobs``).
``evdev:/dev/input/event5``: a foot pedal, button or key of this computer as Linux reports it, one
key of it with ``?key=57``. A terminal is none: it does not tell when a key is let go.

Source: Linux, include/uapi/linux/input.h (EVIOCGKEY) and Documentation/input/event-codes.rst.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import TYPE_CHECKING
from urllib.parse import parse_qs

from cosim.base.errors import InputError
from hil.device.contract import ZERO

if TYPE_CHECKING:
    from hil.device.device import Device

PATIENCE = 30.0
"""How long a person may take to press it (s)."""
KEY_BYTES = 96
"""Of a bit for each key that Linux knows (KEY_MAX is 0x2ff)."""
_GET_KEYS = 2 << 30 | KEY_BYTES << 16 | ord("E") << 8 | 0x18
"""EVIOCGKEY: which keys are down now."""

Held = Callable[[], bool]


def keys_down(descriptor: int) -> int:
    """The keys of an input device that are down now, as a sum of bits.

    Raises:
        OSError: it is none, or not there any more.
    """
    import fcntl

    state = bytearray(KEY_BYTES)
    fcntl.ioctl(descriptor, _GET_KEYS, state)
    return int.from_bytes(state, "little")


class EventKey:
    """A key of a Linux input device, whose state is asked each time: one system call, no wait.

    Its state and not its events, because another program may keep those to itself (EVIOCGRAB), and
    a release among them would never come. A key that is down already when we begin is not held
    until it was seen open, because a stuck one would be. A device that is gone counts as released.
    """

    def __init__(self, path: str, key: int | None = None) -> None:
        self._wanted = -1 if key is None else 1 << key
        try:
            self._file = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            raise InputError(
                f"the dead-man input {path} cannot be opened ({error.strerror}); 'ls "
                "/dev/input/by-id' shows what there is, and group 'input' may read it"
            ) from error
        try:
            self._stuck = keys_down(self._file)
        except OSError as error:
            os.close(self._file)
            raise InputError(
                f"the dead-man input {path} is no input device of Linux ({error.strerror}); 'ls "
                "/dev/input/by-id' shows what there is"
            ) from error
        self._gone = False

    def __call__(self) -> bool:
        """Whether it is held now."""
        if self._gone:
            return False
        try:
            down = keys_down(self._file)
        except OSError:
            self._gone = True
            return False
        self._stuck &= down
        return bool(down & self._wanted & ~self._stuck)

    def close(self) -> None:
        """Let go of it; it is released from then on."""
        self._gone = True
        os.close(self._file)


def open_dead_man(source: str) -> Callable[[Device], Held]:
    """What tells for each device whether the dead-man input is held.

    Raises:
        InputError: the source is unknown, or cannot be opened.
    """
    if source == "device":
        return _of_device
    scheme, _, rest = source.partition(":")
    path, _, query = rest.partition("?")
    if scheme != "evdev" or not path:
        raise InputError(
            f"'{source}' is no dead-man input: write 'device' for a switch on the board itself, or "
            "'evdev:/dev/input/eventN' (with ?key=CODE for one key of it)"
        )
    options = parse_qs(query)
    key = options.pop("key", ["0"])[0]
    if options or not key.isdecimal():
        raise InputError(f"'{source}': the only option is key=CODE, a number of event-codes")
    held = EventKey(path, int(key) or None)

    def for_all(_: Device) -> Held:
        return held

    return for_all


def _of_device(device: Device) -> Held:
    if not device.driver.has_input:
        raise InputError(
            f"the driver '{device.driver.driver}' tells of no switch on its board: give "
            "--dead-man evdev:/dev/input/eventN"
        )
    return lambda: device.input_held


def wait_until_held(device: Device, held: Held, patience: float | None = None) -> bool:
    """Exchange zeros until the input was seen open and is held then; whether it was in time.

    One that was never seen open may be jammed.
    """
    end = time.monotonic() + (PATIENCE if patience is None else patience)
    tick, was_open = 0, isinstance(held, EventKey)  # that one is held from a press on only
    while not (was_open and held()):
        if time.monotonic() > end:
            return False
        device.read(tick)
        device.write(tick, ZERO)
        device.driver.pause()
        was_open |= device.status_is_known and not held()
        tick += 1
    return True
