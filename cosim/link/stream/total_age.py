"""How old a peer's values are where simulated impairments come on top of the real link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cosim.base.component import Causality, Cells, Component, Setup, Variable, VariableType


class TotalAge(Component):
    """Output ``total``: the age ``at_link`` when a packet left it, and the time since then.

    All in base ticks. ``at_link`` comes through the simulated channel and is as old as the values
    that come with it; ``on_the_way`` is what that channel says of its packet's age.
    """

    @property
    def variables(self) -> Sequence[Variable]:
        """Two inputs and an output."""
        return [
            Variable(
                name=name, type=VariableType.INT64, causality=causality, variability="discrete"
            )
            for name, causality in (
                ("at_link", Causality.INPUT),
                ("on_the_way", Causality.INPUT),
                ("total", Causality.OUTPUT),
            )
        ]

    @property
    def dependencies(self) -> Mapping[str, Sequence[str]]:
        """The sum is of the same tick."""
        return {"total": ("at_link", "on_the_way")}

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Keep the views."""
        self._parts = inputs["at_link"], inputs["on_the_way"]
        self._total = outputs["total"]

    def evaluate(self, tick: int) -> None:
        """Add the two."""
        at_link, on_the_way = self._parts
        self._total[0] = at_link[0] + on_the_way[0]
