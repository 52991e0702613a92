"""How a device stands, for those who ask; nothing here changes anything."""

from __future__ import annotations

from cosim.base.system.supervised import DeviceCells
from hil.device.board_exchange import BoardExchange
from hil.device.contract import Flag, State, Status, Watchdog, WriteOutcome
from hil.device.driver import Driver
from hil.device.errors import Cause
from hil.device.life import Life
from hil.device.sample_clock import SampleClock
from hil.safety.layer import SafetyLayer, Trip
from hil.safety.linkage import Pair
from hil.safety.permission import Permission
from hil.setup.address import DeviceAddress
from hil.setup.device_file import DeviceFile

STATES, CAUSES = tuple(State), tuple(Cause)


class DeviceFacts:
    """The parts that a ``Device`` is made of, and what they tell."""

    driver: Driver
    address: DeviceAddress
    file: DeviceFile
    tick: float
    """The control period (s)."""
    permission: Permission | None
    """Who let torque out; ``None``: the output is dry."""
    safety: SafetyLayer
    sent_flags: Flag
    """Of the last write."""
    _life: Life
    _samples: SampleClock
    _exchange: BoardExchange

    @property
    def state(self) -> State:
        """Where it is in its life."""
        return self._life.state

    @property
    def homed(self) -> bool:
        """Whether its angles are those of the device file."""
        return self._life.homed

    @property
    def sent(self) -> Pair:
        """The torque that was last put on the wire (N.m)."""
        return self._exchange.sent

    @property
    def input_held(self) -> bool:
        """Whether the switch on the board was closed in its newest answer."""
        return self._exchange.input_held

    @property
    def latency_ticks(self) -> int:
        """Ticks from a torque to the first sample that can show its effect, beyond the FMU's."""
        return self.driver.latency_of(self.address)

    @property
    def slowness(self) -> str | None:
        """What has to be said of a board that is late as a rule, ``None`` of one in time."""
        return self._exchange.punctuality.sentence(self.name)

    @property
    def rest_ticks(self) -> int:
        """Ticks at zero torque before activation, in which the handle has to rest."""
        return 2 * self.safety.ticks.speed_window

    @property
    def name(self) -> str:
        """What sentences call it."""
        return self.driver.name

    @property
    def watchdog(self) -> Watchdog:
        """What the board does by itself when the host falls silent."""
        return self.driver.watchdog

    @property
    def in_process(self) -> bool:
        """Whether there is no hardware and no other process behind it."""
        return self.driver.in_process

    @property
    def lockstep(self) -> bool:
        """Whether it is an emulator that advances exactly as far as it is asked to."""
        return self.driver.lockstep

    @property
    def drops_torque(self) -> bool:
        """Whether its board has a watchdog that was seen to fire, and soon enough."""
        return self.watchdog.protects

    def cells(self) -> DeviceCells:
        """How it stands, as numbers."""
        angle = self.shown_angle
        force = self.file.linkage.tip_force(angle, self.sent)
        return DeviceCells(
            STATES.index(self._life.state),
            Status.OUTPUT_ENABLED in self.status,
            self.age,
            *angle,
            *self.sent,
            *force,
            self.sent_flags,
            -1 if self.fault is None else CAUSES.index(self.fault.cause),
        )

    @property
    def status(self) -> Status:
        """The bits of the pantograph's ``status`` output."""
        bits = Status.HOMED if self._life.homed else Status(0)
        if self._life.state is State.ACTIVE:
            bits |= Status.ACTIVE
            bits |= Status.OUTPUT_ENABLED if self.permission is not None else Status(0)
        return bits | (Status.FAULT if self._life.state is State.FAULT else Status(0))

    @property
    def status_is_known(self) -> bool:
        """Whether the board has answered since its port was opened."""
        return self._samples.sample is not None

    @property
    def age(self) -> int:
        """Ticks since the last new valid sample."""
        return self._samples.age

    @property
    def shown_angle(self) -> Pair:
        """The newest joint angles (rad), nan before the first sample."""
        return self._samples.joint_angle()

    @property
    def fault(self) -> Trip | None:
        """Why it is in FAULT."""
        return self._life.latch.fault

    @property
    def outcome(self) -> WriteOutcome | None:
        """What is known of the motors after a fault."""
        return self._life.latch.outcome

    @property
    def outcome_ticks(self) -> int:
        """Writes from the fault to its outcome."""
        return self._life.latch.ticks

    @property
    def settled(self) -> bool:
        """Whether it is known what became of the motors after a fault."""
        return self._life.latch.settled

    def fault_sentence(self) -> str:
        """Why it is in FAULT and what is known of its output."""
        return self._life.latch.sentence(self.name, self.watchdog)
