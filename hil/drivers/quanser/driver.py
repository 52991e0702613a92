"""``quanser://q8_usb/0``: a Quanser card: two encoder inputs, two analogue outputs.

Untested on hardware. The maker's package ``quanser.hardware`` comes with its SDK, not from PyPI.
Reading and writing are immediate, so the timing is the FMU's. The card's watchdog drives the
outputs to zero torque; it is fed by writing alone and proved at every opening by letting it expire.
A serial number is not asked for: the package gives that call one byte of room. Source: Quanser's
HIL Python API documentation.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field

from cosim.base.document.form import QuantityIn
from cosim.base.errors import InputError
from hil.device.contract import Received
from hil.device.errors import DeviceGone
from hil.drivers.card import CardDriver
from hil.drivers.quanser.preset import QUANSER
from hil.drivers.samples import sample_of_counts
from hil.safety.linkage import Pair
from hil.setup.options import IntegersIn, UrlOptions, read_options
from hil.setup.preset import Preset
from hil.wire.vendor import VendorSettings, fires, vendor

INSTALL = "install the Quanser SDK (github.com/quanser) with its Python packages"


Channels = Annotated[
    tuple[int, ...],
    IntegersIn(least=0, most=1023, what="two different channel numbers, such as 0,1"),
]


class QuanserOptions(UrlOptions):
    """Options in a card's URL."""

    encoders: Channels = Field(default=(0, 1), description="Channels of the two encoders.")
    outputs: Channels = Field(default=(0, 1), description="Channels of the two outputs.")


class QuanserSettings(VendorSettings):
    """``settings`` in a card's device file."""

    digital_outputs: Annotated[
        int, QuantityIn(unit="1", what="number of digital outputs", least=0, most=1024, whole=True)
    ] = Field(
        default=0,
        description="How many digital outputs go tristate with the watchdog (Q8 cards ask for it).",
    )


class QuanserDriver(CardDriver):
    """Two encoders and two outputs of a card."""

    driver = "quanser"
    settings = QuanserSettings
    options = QuanserOptions
    presets: ClassVar[Mapping[str, Preset]] = {"quanser": QUANSER}

    _card: Any = None

    def open(self) -> None:
        self._module = vendor("quanser.hardware", driver=self.driver, install=INSTALL)
        kind, _, identifier = self.address.place.partition("/")
        if not kind:
            raise InputError(f"'{self.address.url}' does not name a card: write quanser://q8_usb/0")
        self._timeout = self.file.settings_of(QuanserSettings).timeout
        given = read_options(QuanserOptions, self.address)
        self._encoders = array("I", given.encoders)
        self._outputs = array("I", given.outputs)
        self._counts, self._sequence, self._proved = array("i", (0, 0)), 0, False
        try:
            self._card = self._module.HIL(kind, identifier or "0")
            self._card.watchdog_clear()
            self._write(self._rest)
        except self._module.HILError as error:
            raise DeviceGone(f"the card {self.address.place}: {_message(error)}") from error
        self._prove_watchdog()

    def _prove_watchdog(self) -> None:
        """A card without a watchdog can be read and run dry; it is never given output."""
        card, rest = self._card, array("d", self._rest)
        digital = self.file.settings_of(QuanserSettings).digital_outputs
        tristate = self._module.DigitalState.TRISTATE
        try:
            card.watchdog_set_analog_expiration_state(self._outputs, 2, rest)
            if digital:
                lines = array("I", range(digital))
                states = array("i", [tristate] * digital)
                card.watchdog_set_digital_expiration_state(lines, digital, states)
            card.watchdog_start(self._timeout)
            fired = fires(card.watchdog_is_expired, self.pause, self._timeout / self.tick)
            card.watchdog_clear()
            self._write(self._rest)
            card.watchdog_start(self._timeout)
            self._proved = bool(fired)
        except self._module.HILError:
            self._proved = False

    def receive(self) -> Received:
        try:
            self._card.read_encoder(self._encoders, 2, self._counts)
        except self._module.HILError as error:
            raise DeviceGone(f"the card does not answer: {_message(error)}") from error
        first, second = self._counts
        self._sequence += 1
        sample = sample_of_counts(self.file.joints, (first, second), self._sequence)
        return Received(sample=sample, zero_confirmed=self._zero)

    def _put(self, voltage: Pair) -> bool:
        try:
            self._write(voltage)
            alive = not self._proved or self._card.watchdog_reload()
        except self._module.HILError as error:
            raise DeviceGone(f"the card takes no output: {_message(error)}") from error
        return bool(alive)

    def _write(self, voltage: Pair) -> None:
        self._card.write_analog(self._outputs, 2, array("d", voltage))

    def close(self) -> None:
        if self._card is not None:
            card, self._card = self._card, None
            try:
                card.watchdog_stop()
            finally:
                card.close()


def _message(error: Any) -> str:
    return str(error.get_error_message())
