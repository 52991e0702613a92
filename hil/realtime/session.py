"""What holds for every device of one run: is output allowed, who confirms, who supervises.

The command line fills it in before the scenario's components are made; devices made without it get
the defaults, which are the safe ones: dry output, nobody to ask, no supervisor.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from hil.device.errors import ActivationRefused
from hil.safety.dead_man import Held, wait_until_held
from hil.safety.permission import Permission, ask, dead_man, emulated

if TYPE_CHECKING:
    from cosim.base.pulse import Pulse
    from hil.device.device import Device


@dataclass(slots=True, kw_only=True)
class Session:
    """One run's devices and their permissions.

    ``prompt`` asks a person and returns the answer; ``say`` shows a sentence; ``clock`` gives
    seconds for the lateness rule, ``None`` for a simulation that is not paced.
    """

    enable_output: bool = False
    yes: bool = False
    dead_man: Callable[[Device], Held] | None = None
    """What tells whether a device's dead-man input is held, where there is one."""
    prompt: Callable[[str], str] | None = None
    say: Callable[[str], None] | None = None
    clock: Callable[[], float] | None = None
    pulse: Pulse | None = None
    number: int = 0
    """Which of the run's devices the next one is; the supervisor knows them by it."""
    devices: list[Device] = field(default_factory=list["Device"])
    ready: dict[str, Device] = field(default_factory=dict[str, "Device"])
    """Devices by component name that the supervisor opened before the loop was forked."""

    def permission(self, device: Device) -> Permission | None:
        """The permission for one device, confirmed now; ``None`` keeps its output dry.

        Raises:
            ActivationRefused: output was asked for and not confirmed.
        """
        from hil.emulation.proof import doubt

        if not self.enable_output:
            return None
        given: Permission | None = None
        if self.yes:
            given = emulated(device.name, None if device.in_process else doubt(device))
        if self.dead_man is not None:
            return self._held(device, self.dead_man(device), given)
        if given is not None:
            return given
        if self.prompt is None:
            raise ActivationRefused(
                f"{device.name} stays without output: there is nobody to confirm it"
            )
        return ask(device.name, device.warnings(), self.prompt)

    def _held(self, device: Device, held: Held, given: Permission | None) -> Permission:
        for warning in device.warnings():
            self.tell(warning)
        self.tell(f"Hold the dead-man input to let {device.name} produce force.")
        wait_until_held(device, held)
        return dead_man(device.name, held, given)

    def tell(self, text: str) -> None:
        """Show a sentence where there is somebody to show it to."""
        if self.say is not None:
            self.say(text)

    def hold_home_pose(self, device: Device) -> None:
        """Have a person hold the handle at its home pose; an emulator holds it by itself."""
        if self.prompt is None or device.in_process or self.yes:
            return
        self.prompt(f"Hold the handle of {device.name} at its home pose and press Enter: ")

    def request_stop(self) -> None:
        """Have every device zeroed at its next write (for signal handlers: sets flags only)."""
        for device in self.devices:
            device.stop_requested = True


_current = [Session()]


def current() -> Session:
    """The session that new device components belong to: dry, unless one was begun."""
    return _current[0]


def begin(session: Session) -> Session:
    """Make a session the current one, and return it."""
    _current[0] = session
    return session
