"""What holds for every device of one run: is output allowed, who confirms, who supervises.

The command line fills it in before the scenario's components are made; devices made without it get
the defaults, which are the safe ones: dry output, nobody to ask, no supervisor.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from cosim.base.system.sleep import Wakefulness
from hil.device.errors import ActivationRefused
from hil.device.life import Alarm
from hil.device.warnings import warnings_of
from hil.safety.dead_man import Held, wait_until_held
from hil.safety.permission import Permission, ask, dead_man, emulated
from hil.setup.emulator_proof import doubt

if TYPE_CHECKING:
    from hil.device.device import Device


@dataclass(slots=True, kw_only=True)
class Session:
    """One run's devices and their permissions.

    ``prompt`` asks a person and returns the answer; ``say`` shows a sentence.
    """

    enable_output: bool = False
    yes: bool = False
    dead_man: Callable[[Device], Held] | None = None
    """What tells whether a device's dead-man input is held, where there is one."""
    prompt: Callable[[str], str] | None = None
    say: Callable[[str], None] | None = None
    alarm: Alarm = field(default_factory=Alarm)
    """What the run's devices share."""
    wakefulness: Wakefulness = field(default_factory=Wakefulness)
    """What keeps the machine awake while devices may push."""
    asked: dict[str, Permission | None] = field(default_factory=dict[str, "Permission | None"])
    """By device: what people said before it was opened, where nobody can be asked then."""

    def permission(self, device: Device) -> Permission | None:
        """The permission for one device, confirmed now; ``None`` keeps its output dry.

        Raises:
            ActivationRefused: output was asked for and not confirmed.
        """
        if not self.enable_output:
            return None
        if device.name in self.asked and self.dead_man is None:
            return self.asked[device.name]
        given: Permission | None = None
        if self.yes:
            given = emulated(device.name, doubt_of(device))
        if self.dead_man is not None:
            return self._held(device, self.dead_man(device), given)
        if given is not None:
            return given
        if self.prompt is None:
            raise ActivationRefused(
                f"{device.name} stays without output: there is nobody to confirm it"
            )
        return ask(device.name, warnings_of(device), self.prompt)

    def _held(self, device: Device, held: Held, given: Permission | None) -> Permission:
        for warning in warnings_of(device):
            self.tell(warning)
        self.tell(f"Hold the dead-man input to let {device.name} produce force.")
        if not wait_until_held(device, held):
            raise ActivationRefused(
                f"{device.name} stays without output: the dead-man input was not seen open and "
                "then held; let go of it first, and look whether it is jammed"
            )
        return dead_man(device.name, held, given)

    def keep_awake(self, device: Device) -> None:
        """Keep the machine awake for a device that may push.

        Raises:
            ActivationRefused: it may fall asleep, and nothing would switch off the motors then.
        """
        permission = device.permission
        if permission is None or device.in_process:
            return
        refused = self.wakefulness.keep()
        if refused is None or device.watchdog.protects or permission.how.startswith("emulator"):
            return
        raise ActivationRefused(
            f"{device.name} has no watchdog, and this machine may fall asleep while it pushes "
            f"({refused}): switch its sleep off ('systemctl mask sleep.target suspend.target'), or "
            "start the command as somebody whom it grants to keep it awake"
        )

    def tell(self, text: str) -> None:
        """Show a sentence where there is somebody to show it to."""
        if self.say is not None:
            self.say(text)

    def hold_home_pose(self, device: Device) -> None:
        """Have a person hold the handle at its home pose.

        An emulator that proves to be one is homed without.

        Raises:
            ActivationRefused: there is nobody to hold it.
        """
        if device.file.home is None or device.in_process or device.name in self.asked:
            return
        if self.prompt is not None and not self.yes:
            self.prompt(f"Hold the handle of {device.name} at its home pose and press Enter: ")
            return
        doubtful = doubt_of(device)
        if doubtful is not None:
            raise ActivationRefused(
                f"{device.name} is not homed: nobody is at a terminal to hold its handle at the "
                f"home pose, and it did not prove to be an emulator ({doubtful})"
            )

    def ask_ahead(self, device: Device) -> None:
        """Ask what :meth:`permission` and :meth:`hold_home_pose` would, of a device not open yet.

        A dead-man input answers for itself, once the device is open.

        Raises:
            ActivationRefused: output was asked for and not confirmed.
        """
        if self.yes or self.prompt is None:
            return
        given: Permission | None = None
        if self.enable_output and self.dead_man is None:
            given = ask(device.name, warnings_of(device), self.prompt)
        if device.file.home is not None:
            self.prompt(
                f"Hold the handle of {device.name} at its home pose from now until the run has "
                "begun, and press Enter: "
            )
        self.asked[device.name] = given


def doubt_of(device: Device) -> str | None:
    """Why a configured device may not be an emulator; ``None`` where it is one."""
    return None if device.in_process else doubt(device)


_current = [Session()]


def current() -> Session:
    """The session that new device components belong to: dry, unless one was begun."""
    return _current[0]


def begin(session: Session) -> Session:
    """Make a session the current one, and return it."""
    _current[0] = session
    return session
