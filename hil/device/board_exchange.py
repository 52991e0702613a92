"""The exchange with one board: what was last put on the wire, and what its answers say."""

from __future__ import annotations

from hil.device.contract import ZERO, Received
from hil.device.driver import Driver
from hil.device.errors import DeviceError, HalfSent
from hil.device.punctuality import Punctuality
from hil.device.sample_clock import SampleClock
from hil.safety.linkage import Pair

FIRST_SAMPLE_TRIES = 50
"""Exchanges within which a device has to answer for the first time."""


class BoardExchange:
    """A driver, the clock of its samples, and the torque on its wire.

    It raises what the driver raises; who calls it judges that.
    """

    def __init__(self, driver: Driver, samples: SampleClock) -> None:
        self.driver, self.samples = driver, samples
        self.sent: Pair = ZERO
        """The torque that was last put on the wire (N.m); zero once an answer confirms zero."""
        self.zeroing = False
        """Whether the last thing put on the wire is a zero that no answer has confirmed yet."""
        self.input_held = False
        """Whether the switch on the board was closed in all answers that came last."""
        self.zeros = 0
        """Answers so far that confirmed zero."""
        self.punctuality = Punctuality(driver.tick)

    def restart(self) -> None:
        """The port was opened: the board answers, and is at zero."""
        self.sent, self.zeroing, self.input_held = ZERO, False, False

    def send(self, torque: Pair) -> bool:
        """Whether it went out; what did not leaves the wire's last torque as it was."""
        pulse = self.driver.pulse
        if pulse is not None and torque != ZERO:
            pulse.heat(self.driver.number)
        try:
            sent = self.driver.send(torque)
        except HalfSent as error:
            first, second = (error.torque.get(joint, self.sent[joint]) for joint in (0, 1))
            self.sent, self.zeroing = (first, second), False
            raise
        self.punctuality.count(sent=sent is not None)
        if sent is not None:
            self.sent, self.zeroing = sent, False
        return sent is not None

    def send_zero(self) -> bool:
        """Whether a zero went out, or is known to be there; ``sent`` waits for the answer."""
        sent = self.driver.send_zero()
        self.zeroing |= sent and self.sent != ZERO
        return sent

    def receive(self) -> Received:
        """What came; a confirmed zero is noted, for the supervisor as well."""
        received = self.driver.receive()
        held = [each.input_held for each in received.each if each.input_held is not None]
        self.input_held = all(held) if held else self.input_held
        if received.zero_confirmed:
            self.zeros += 1
            self.sent, self.zeroing = ZERO, False
            if self.driver.pulse is not None:
                self.driver.pulse.cool(self.driver.number)
        if received.sample is not None:
            self.samples.take(received.sample, received.device_time)
        return received

    def check_serial(self) -> None:
        """Refuse another device than the one that the device file describes.

        Raises:
            DeviceError: it is another one.
        """
        driver = self.driver
        expected, found = driver.file.serial, driver.serial()
        if expected is not None and found is not None and expected != found:
            raise DeviceError(
                f"{driver.name} has serial number {found}, its device file is for {expected}: "
                "plug in the right one or calibrate this one"
            )
