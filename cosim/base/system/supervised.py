"""A device as a paced run sees it, whatever it is: opened, kept at zero, taken over, told of.

``hil`` has the devices; the processes of ``cosim.realtime`` know no more of them than this.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol, runtime_checkable

from cosim.base.system.pulse import Pulse


@dataclass(frozen=True, slots=True)
class DeviceCells:
    """One device at a tick, as a row of numbers that goes into shared memory.

    ``state`` and ``cause`` are places in :attr:`Opens.states` and :attr:`Opens.causes`
    (-1: no fault); angles in rad, torques in N.m, the force at the tip in N.
    """

    state: float
    output: float
    """1 where it is allowed to push."""
    age: float
    """Ticks since the last new sample."""
    angle_1: float
    angle_2: float
    torque_1: float
    torque_2: float
    force_1: float
    force_2: float
    flags: float
    cause: float


class Supervised(Protocol):
    """An open device."""

    @property
    def name(self) -> str:
        """What sentences call it."""
        ...

    @property
    def in_process(self) -> bool:
        """Whether there is no hardware and no other process behind it."""
        ...

    @property
    def lockstep(self) -> bool:
        """Whether it advances exactly as far as it is asked to, and no clock matters."""
        ...

    @property
    def drops_torque(self) -> bool:
        """Whether its board has a watchdog that was seen to fire."""
        ...

    @property
    def latency_ticks(self) -> int:
        """Ticks from a torque to the first sample that can show its effect, beyond the FMU's."""
        ...

    @property
    def slowness(self) -> str | None:
        """What has to be said of a board that takes no command at many ticks."""
        ...

    def cells(self) -> DeviceCells:
        """How it stands."""
        ...

    def idle(self) -> None:
        """One exchange at zero torque, before the first tick.

        Raises:
            RunError: it is in fault.
        """
        ...

    def zero_after_death(self, *, torn: bool) -> bool:
        """Send zero until an answer confirms it; whether one did.

        For a process that takes the open port over. ``torn``: the other one died while it was
        writing a frame.
        """
        ...

    def release(self) -> None:
        """Let go of the port without a word on the wire."""
        ...

    def close(self) -> None:
        """Zero it as well as can be, and let go of the port."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Opening:
    """What a device is told as it is opened. ``tick`` is its control period (s)."""

    name: str
    number: int
    tick: Fraction
    parameters: Mapping[str, Any]
    pulse: Pulse | None = None
    clock: Callable[[], float] | None = None
    """Host seconds for the rule on lateness; ``None`` where the run is not paced."""


@runtime_checkable
class Opens(Protocol):
    """A component that stands for a device."""

    @property
    def states(self) -> Sequence[str]:
        """Names of the states of its life."""
        ...

    @property
    def causes(self) -> Sequence[str]:
        """Names of what can end in a fault."""
        ...

    @property
    def shares_port(self) -> bool:
        """Whether other processes can go on with its open port."""
        ...

    def ask(self) -> None:
        """Ask people what has to be asked before a device is opened where nobody can be asked."""
        ...

    def open(self, opening: Opening) -> Supervised:
        """Configure and home the device; it is the component's from then on."""
        ...
