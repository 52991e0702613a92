"""``moteus:///dev/fdcanusb?ids=1,2``, ``moteus+socketcan://can0``: two moteus controllers.

Untested on hardware. The maker's package ``moteus`` does the encoding and the bus; it lives in an
event loop of its own that runs only inside a call, so no thread is added. Position mode without
gains and with a feedforward torque is torque mode. Every torque command carries the servo's
watchdog timeout, and queries do not feed it; after it the servo has to be *stopped*
(``servo.timeout_mode 0``), which is read back and proved at every opening. Source: mjbots'
reference for moteus and its Python library.
"""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from math import isfinite, nan
from typing import Annotated, Any, ClassVar

from pydantic import Field

from cosim.base.document.form import QuantityIn
from cosim.base.errors import InputError
from hil.device.contract import NOTHING, ZERO, Received, Watchdog
from hil.device.driver import Driver
from hil.device.errors import BoardError, DeviceError, DeviceGone, ProtocolError
from hil.drivers.samples import sample_of_turns
from hil.safety.conversion import TorqueDrive
from hil.safety.linkage import Pair
from hil.setup.options import IntegersIn, UrlOptions, read_options
from hil.wire.vendor import VendorSettings, fires, vendor

INSTALL = "run 'pip install moteus>=1.1' to install it"
STOPPED, FAULT, POSITION, TIMEOUT = 0, 1, 10, 11
"""Values of the mode register."""
ANSWER_SECONDS = 0.002
"""How long the bus may take (``?budget=``, s); after that a sample counts as missing."""
SET_UP_SECONDS = 2.0
TRIES = 50


class MoteusOptions(UrlOptions):
    """Options in the URL of two controllers."""

    ids: Annotated[
        tuple[int, ...],
        IntegersIn(least=1, most=127, what="two different numbers of 1 to 127, such as 1,2"),
    ] = Field(default=(1, 2), description="The controllers of joint 1 and 2.")
    budget: Annotated[
        float, QuantityIn(unit="s", what="time, such as 0.002 or '2 ms'", above=0, most=600)
    ] = Field(default=ANSWER_SECONDS, description="How long the bus may take (s).")


class MoteusDriver(Driver):
    """Two axes in turns and N.m."""

    driver = "moteus"
    settings = VendorSettings
    options = MoteusOptions
    shares_port: ClassVar[bool] = False

    _transport: Any = None
    _loop: asyncio.AbstractEventLoop | None = None
    _proved: bool = False
    _entered: bool = False

    @property
    def watchdog(self) -> Watchdog:
        """In every torque command; verified once the servos were seen to stop by themselves."""
        return Watchdog(timeout=self._timeout if self._proved else None, verified=self._proved)

    def open(self) -> None:
        self._moteus = vendor("moteus", driver=self.driver, install=INSTALL)
        self._timeout = self.file.settings_of(VendorSettings).timeout
        given = read_options(MoteusOptions, self.address)
        self._ids, self._budget = given.ids, given.budget
        self._sequence, self._proved = 0, False
        self._modes: dict[int, int] = {}
        if not self.address.place:
            raise InputError(
                f"'{self.address.url}' names no bus: write moteus:///dev/fdcanusb or "
                "moteus+socketcan://can0"
            )
        self._loop = asyncio.new_event_loop()
        try:
            self._transport = self._loop.run_until_complete(self._bus())
        except Exception as error:  # whatever the package raises, the sentence is the same
            raise DeviceGone(f"no bus at {self.address.url}: {error}") from error
        self._axes = [
            self._moteus.Controller(id=each, transport=self._transport) for each in self._ids
        ]
        for _ in range(TRIES):
            self.send_zero()
            if self.receive().sample is not None and set(self._modes.values()) == {STOPPED}:
                break
            self.pause()
        else:
            raise DeviceError(f"{self.name}: controllers {self._ids} do not answer, or do not stop")
        self._prove_watchdog()

    async def _bus(self) -> Any:
        """Opened inside the event loop: the package's adapters look for a running one."""
        place, transport = self.address.place, self.address.transport
        if transport is None:
            # No second sending: a torque that comes late is worse than none.
            patience = dict.fromkeys(("command_timeout", "response_timeout"), self._budget)
            return self._moteus.Fdcanusb(place, max_retries=0, **patience)
        return self._moteus.PythonCan(interface=transport, channel=place, fd=True)

    def _prove_watchdog(self) -> None:
        """At zero torque: are the servos set to stop on a timeout, and do they time out?"""
        for axis in self._axes:
            stream = self._moteus.Stream(axis)
            answer = self._run(
                stream.command(b"conf get servo.timeout_mode", allow_any_response=True),
                SET_UP_SECONDS,
            )
            if answer is None or answer.strip() != b"0":
                return
        self.send(ZERO)

        def expired() -> bool:
            self.receive()
            return set(self._modes.values()) == {TIMEOUT}

        self._proved = fires(expired, self.pause, self._timeout / self.tick)
        self.send_zero()

    def receive(self) -> Received:
        results = self._run(
            self._transport.cycle([axis.make_query() for axis in self._axes]), self._budget
        )
        found = {result.id: result.values for result in results or ()}
        if not all(each in found for each in self._ids):
            return NOTHING
        register = self._moteus.Register
        turns: list[float] = []
        wrong: BoardError | None = None
        astray = ""
        for each in self._ids:
            values = found[each]
            turns.append(float(values[register.POSITION]))
            self._modes[each] = int(values[register.MODE])
            fault = int(values.get(register.FAULT, 0))
            if self._entered and self._modes[each] != POSITION:
                wrong = BoardError(
                    f"moteus {each} left position mode: it is in mode {self._modes[each]}, "
                    f"fault {fault}"
                )
            elif not self._entered and self._modes[each] != STOPPED:
                mode = self._modes[each]
                astray = f"moteus {each} was told to stop, and is in mode {mode}, fault {fault}"
        if not all(isfinite(turn) for turn in turns):
            raise ProtocolError("a moteus reports a position that is no number")
        self._sequence += 1
        return Received(
            sample=sample_of_turns(self.file.joints, (turns[0], turns[1]), self._sequence),
            zero_confirmed=set(self._modes.values()) == {STOPPED},
            contradiction=astray,
            error=wrong,
        )

    def send(self, torque: Pair) -> Pair:
        commands: list[Any] = []
        sent: list[float] = []
        for axis, joint, value in zip(self._axes, self.file.joints, torque, strict=True):
            if not isinstance(joint.drive, TorqueDrive):
                raise InputError("a moteus takes torque: its 'drive' has a gear and a direction")
            code = joint.drive.encode(value)
            commands.append(
                axis.make_position(
                    position=nan,
                    velocity=0.0,
                    kp_scale=0.0,
                    kd_scale=0.0,
                    ilimit_scale=0.0,
                    feedforward_torque=code,
                    maximum_torque=self.file.limits.torque / joint.drive.gear,
                    watchdog_timeout=self._timeout,
                )
            )
            sent.append(joint.drive.decode(code))
        self._put(commands)
        return sent[0], sent[1]

    def send_zero(self) -> bool:
        """Stopped is without torque, and the only way out of a timeout."""
        self._entered = False
        self._put([axis.make_stop() for axis in self._axes])
        return True

    def _put(self, commands: list[Any]) -> None:
        if self._run(self._transport.cycle(commands), self._budget) is None:
            raise DeviceGone("the bus does not take a command")

    def enter(self) -> None:
        for _ in range(TRIES):
            self.send(ZERO)
            self.receive()
            if set(self._modes.values()) == {POSITION}:
                self._entered = True
                return
            self.pause()
        raise DeviceError(f"{self.name}: a controller does not enter position mode")

    def leave(self) -> None:
        self.send_zero()

    def _run(self, call: Coroutine[Any, Any, Any], seconds: float) -> Any:
        """What the package answers; ``None`` where nothing came in time."""
        assert self._loop is not None, "configure comes first"
        try:
            return self._loop.run_until_complete(asyncio.wait_for(call, seconds))
        except TimeoutError:
            return None
        except Exception as error:  # the package has errors of its own and those of two buses
            raise DeviceGone(f"the bus is gone: {type(error).__name__}: {error}") from error

    def close(self) -> None:
        transport, self._transport = self._transport, None
        loop, self._loop = self._loop, None
        if loop is None:
            return
        try:
            if transport is not None:
                loop.run_until_complete(_end(transport))
        finally:
            loop.close()


async def _end(transport: Any) -> None:
    """Close a bus, and wait for what the package still has running."""
    transport.close()
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for task in others:
        task.cancel()
    await asyncio.gather(*others, return_exceptions=True)
