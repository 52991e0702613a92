"""``expect:`` in a scenario: predicates over what was measured, which make the scenario a test.

A predicate is ``<measure>_<comparison>: threshold``. The measures are in ``cosim.report.window``;
comparisons are ``below`` and ``above`` (strictly), ``within: [low, high]`` and ``equals``. Without
a measure a comparison means every value. ``from`` and ``to`` (s) bound the window, ``to`` included.

::

    expect:
      vr_a.box_pose.y: {max_abs_below: 0.06, final_within: [-1 mm, 1 mm]}
      vr_a.finger_1.normal_force: {from: 2, to: 8, min_above: 0.5, std_below: 0.1}
      vr_a.box_pose.x - vr_b.box_pose.x: {rms_below: 0.5 mm}
      user_a.force[1]:
        start: {to: 1, max_below: 2}            # several windows: each has a name of its own
        carry: {from: 2, to: 8, amplitude_within: [0.1, 0.2], frequency: 2}
      contact_losses: {equals: 0, from: 2}      # of the whole scenario: cosim/report/measures.py
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from cosim.report.measures import TickRange
from cosim.report.runaway import bound_of
from cosim.report.target import Target

COMPARISONS: dict[str, Callable[[float, float, Sequence[float]], bool]] = {
    "below": lambda _, high, limit: high < limit[0],
    "above": lambda low, _, limit: low > limit[0],
    "within": lambda low, high, limit: limit[0] <= low and high <= limit[1],
    "equals": lambda low, high, limit: low == high == limit[0],
}
"""Whether everything between ``low`` and ``high`` keeps the limit."""

OPTIONS = ("from", "to", "frequency")


@dataclass(frozen=True, slots=True, kw_only=True)
class Expectation:
    """One predicate, checked and ready to be evaluated.

    ``target`` is a signal's, or the name of a measure of the whole scenario. ``window`` is in base
    ticks; ``None`` where the scenario gives none. ``until`` is its end where one is written: the
    run has to come so far. ``frequency`` is in rad/s.
    """

    text: str
    target: Target | None
    label: str
    measure: str
    comparison: str
    limit: tuple[float, ...]
    window: TickRange | None
    until: int | None
    frequency: float | None
    unit: str

    @property
    def name(self) -> str:
        """What tells it from the scenario's others."""
        label = f"[{self.label}]" if self.label else ""
        return f"{self.text}{label} {self.predicate}"

    @property
    def is_of_divergence(self) -> bool:
        """Whether it speaks of growth, or of sizes that only what ran away has."""
        far = max(map(abs, self.limit)) >= bound_of(self.unit)
        return far or self.measure == "growth"

    @property
    def predicate(self) -> str:
        """As the scenario writes it."""
        return f"{self.measure}_{self.comparison}" if self.measure else self.comparison
