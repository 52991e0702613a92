"""Knobs that a page turns, as a component: what they stand at is a signal, recorded like any other.

It stands at its ``start`` until a page says otherwise; connections carry its values to the dials of
channels and to tunable parameters. Played back, they turn again at the same ticks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cosim.base.component import Causality, Cells, Component, Setup, Variable
from cosim.realtime.ring import Ring

KNOBS = 16
"""Values of one panel."""

VARIABLES = (
    Variable(
        name="value",
        causality=Causality.OUTPUT,
        unit="",
        shape=(KNOBS,),
        start=0.0,
        description="What each knob stands at, in the SI unit of what it turns",
    ),
    Variable(
        name="start",
        causality=Causality.PARAMETER,
        variability="fixed",
        unit="",
        shape=(KNOBS,),
        start=0.0,
        description="What each knob stands at until it is turned",
    ),
)


class KnobPanel(Component):
    """Shows the newest row of a ring; the start values before there is one."""

    feedthrough = False

    def __init__(self, ring: Ring | None = None) -> None:
        self._ring = ring
        self._seen = 0

    @property
    def variables(self) -> Sequence[Variable]:
        """The knobs' values, and where they begin."""
        return VARIABLES

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Knobs stand where they begin, or where they were left in the take before."""
        self._values = outputs["value"]
        self._values[:] = setup.parameters.get("start", 0.0)
        self._seen = 0
        self.read(0)

    def read(self, tick: int) -> None:
        """Take what was turned last."""
        ring = self._ring
        if ring is None or ring.written == self._seen:
            return
        row = ring.newest(tries=3)
        if row is not None:
            self._seen = ring.written
            self._values[:] = row
