"""``mock://``: the simulated pantograph in this very process; for tutorials and the test suite."""

from __future__ import annotations

from math import pi
from typing import Any, ClassVar

from hil.device.contract import ZERO, Received, Sample, Watchdog
from hil.device.driver import Driver
from hil.emulation.plant import Body, SimulatedPantograph
from hil.safety.linkage import Pair
from hil.setup.registry import find_preset


class MockDriver(Driver):
    """A pantograph without a wire: what it measures at a tick is there at that tick."""

    driver = "mock"
    in_process: ClassVar[bool] = True
    command_unit = None
    tested_on_hardware: ClassVar[bool] = True

    _zero = False
    body: Body | None = None
    """What to move instead of the simulated pantograph (tests)."""

    @property
    def watchdog(self) -> Watchdog:
        """It cannot outlive its host."""
        return Watchdog(timeout=self.tick, verified=True)

    def open(self) -> None:
        if self.body is None:
            self.body = SimulatedPantograph(self._model_parameters(), step=self.tick)
        self._sequence, self._zero = 0, False

    def receive(self) -> Received:
        assert self.body is not None
        angle = self.body.angle()
        shaft: list[float] = []
        count: list[int] = []
        for index, joint in enumerate(self.file.joints):
            per = joint.counts_per_turn / (2 * pi)
            turned = joint.direction * (angle[index] - joint.offset)
            count.append(round(turned * per))
            shaft.append(count[-1] / per)
        self._sequence += 1
        sample = Sample(
            shaft_angle=(shaft[0], shaft[1]), count=(count[0], count[1]), sequence=self._sequence
        )
        return Received(sample=sample, zero_confirmed=self._zero)

    def send(self, torque: Pair) -> Pair:
        assert self.body is not None
        sent: list[float] = []
        for index, joint in enumerate(self.file.joints):
            sent.append(joint.drive.sendable(torque[index]))
        applied = (sent[0], sent[1])
        self.body.step(applied)
        self._zero = applied == ZERO
        return applied

    def send_zero(self) -> bool:
        self.send(ZERO)
        return True

    def close(self) -> None:
        if self.body is not None:
            self.body.close()
            self.body = None

    def _model_parameters(self) -> dict[str, Any]:
        return {**find_preset(self.file.preset, type(self)).parameters, **self.parameters}
