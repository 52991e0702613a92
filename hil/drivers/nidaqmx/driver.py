"""``nidaqmx://Dev1``: an NI card: two counters as encoder inputs, two analogue outputs.

Untested on hardware. The package ``nidaqmx`` and NI's driver have to be installed. Reading and
writing are on demand, so the timing is the FMU's. Few NI devices have a watchdog timer for analogue
outputs; where one has, it drives them to zero torque, is fed by writing alone, and is proved at
every opening by letting it expire. Where none is, the device runs dry. Source: nidaqmx-python's API
documentation.
"""

from __future__ import annotations

from math import isfinite
from typing import Annotated, Any

from pydantic import Field

from cosim.base.errors import InputError
from hil.device.contract import Received
from hil.device.errors import DeviceGone, ProtocolError
from hil.drivers.card import CardDriver
from hil.drivers.samples import sample_of_counts
from hil.safety.linkage import Pair
from hil.setup.options import IntegersIn, UrlOptions, read_options
from hil.wire.vendor import VendorSettings, fires, vendor

INSTALL = "run 'pip install nidaqmx' and install NI-DAQmx"
READ_SECONDS = 0.005
"""How long a call may wait for the card."""


Channels = Annotated[
    tuple[int, ...],
    IntegersIn(least=0, most=1023, what="two different channel numbers, such as 0,1"),
]


class NidaqmxOptions(UrlOptions):
    """Options in a card's URL."""

    counters: Channels = Field(default=(0, 1), description="N of the two encoders' `ctrN`.")
    outputs: Channels = Field(default=(0, 1), description="N of the two outputs' `aoN`.")


class NidaqmxDriver(CardDriver):
    """Two counters and two outputs of a card."""

    driver = "nidaqmx"
    settings = VendorSettings
    options = NidaqmxOptions

    _output: Any = None
    _guard_task: Any = None

    def open(self) -> None:
        if not self.address.place:
            raise InputError(f"'{self.address.url}' does not name a card: write nidaqmx://Dev1")
        self._ni = vendor("nidaqmx", driver=self.driver, install=INSTALL)
        self._constants = vendor("nidaqmx.constants", driver=self.driver, install=INSTALL)
        self._error: type[Exception] = vendor(
            "nidaqmx.errors", driver=self.driver, install=INSTALL
        ).Error
        self._timeout = self.file.settings_of(VendorSettings).timeout
        self._tasks: list[Any] = []
        self._sequence, self._proved = 0, False
        try:
            counters = read_options(NidaqmxOptions, self.address).counters
            self._counters = [self._counter(number) for number in counters]
            self._output = self._analogue_output()
            self._write(self._rest)
        except self._error as error:
            raise DeviceGone(f"the card {self.address.place}: {error}") from error
        self._prove_watchdog()

    def _task(self) -> Any:
        self._tasks.append(self._ni.Task())
        return self._tasks[-1]

    def _counter(self, number: int) -> Any:
        task = self._task()
        task.ci_channels.add_ci_ang_encoder_chan(
            f"{self.address.place}/ctr{number}",
            decoding_type=self._constants.EncoderType.X_4,
            units=self._constants.AngleUnits.TICKS,
        )
        task.start()
        return task

    def _analogue_output(self) -> Any:
        task = self._task()
        for name in self._channels():
            task.ao_channels.add_ao_voltage_chan(name, min_val=-10.0, max_val=10.0)
        return task

    def _channels(self) -> list[str]:
        found = read_options(NidaqmxOptions, self.address).outputs
        return [f"{self.address.place}/ao{number}" for number in found]

    def _prove_watchdog(self) -> None:
        """A card without a watchdog can be read and run dry; it is never given output."""
        try:
            system = vendor("nidaqmx.system.watchdog", driver=self.driver, install=INSTALL)
            task = system.WatchdogTask(self.address.place, timeout=self._timeout)
            self._tasks.append(task)
            voltage = self._constants.WatchdogAOExpirState.VOLTAGE
            rest = zip(self._channels(), self._rest, strict=True)
            task.cfg_watchdog_ao_expir_states(
                [system.AOExpirationState(name, value, voltage) for name, value in rest]
            )
            task.start()
            fired = fires(lambda: bool(task.expired), self.pause, self._timeout / self.tick)
            task.clear_expiration()
            self._write(self._rest)
            task.reset_timer()
            self._guard_task, self._proved = task, fired
        except self._error:
            self._guard_task, self._proved = None, False

    def receive(self) -> Received:
        try:
            found = [float(task.read(timeout=READ_SECONDS)) for task in self._counters]
        except self._error as error:
            raise DeviceGone(f"the card does not answer: {error}") from error
        if not all(isfinite(each) for each in found):
            raise ProtocolError("a counter of the card reports something that is no number")
        first, second = round(found[0]), round(found[1])
        self._sequence += 1
        sample = sample_of_counts(self.file.joints, (first, second), self._sequence)
        return Received(sample=sample, zero_confirmed=self._zero)

    def _put(self, voltage: Pair) -> bool:
        try:
            self._write(voltage)
            expired = False
            if self._guard_task is not None:
                expired = bool(self._guard_task.expired)
                self._guard_task.reset_timer()
        except self._error as error:
            raise DeviceGone(f"the card takes no output: {error}") from error
        return not expired

    def _write(self, voltage: Pair) -> None:
        self._output.write(list(voltage), auto_start=True, timeout=READ_SECONDS)

    def close(self) -> None:
        self._output = self._guard_task = None
        while getattr(self, "_tasks", None):
            self._tasks.pop().close()
