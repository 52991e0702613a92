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

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from cosim.base.document.show import show
from cosim.base.errors import InputError, InputErrors
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.base.suggest import did_you_mean
from cosim.report.measures import SCENARIO_MEASURES, Inspection, TickRange
from cosim.report.target import Target, parse_target
from cosim.report.window import MEASURES, measure
from cosim.scenario import Scenario

COMPARISONS: dict[str, Callable[[float, float, Sequence[float]], bool]] = {
    "below": lambda _, high, limit: high < limit[0],
    "above": lambda low, _, limit: low > limit[0],
    "within": lambda low, high, limit: limit[0] <= low and high <= limit[1],
    "equals": lambda low, high, limit: low == high == limit[0],
}
"""Whether everything between ``low`` and ``high`` keeps the limit."""

_OWN_UNITS = {"change_count": "", "loss_count": "", "growth": "1/s"}
"""Measures that are not in the unit of what is measured."""

OPTIONS = ("from", "to", "frequency")


@dataclass(frozen=True, slots=True, kw_only=True)
class Expectation:
    """One predicate, checked and ready to be evaluated.

    ``target`` is a signal's, or the name of a measure of the whole scenario. ``window`` is in base
    ticks; ``None`` where the scenario gives none. ``frequency`` is in rad/s.
    """

    text: str
    target: Target | None
    label: str
    measure: str
    comparison: str
    limit: tuple[float, ...]
    window: TickRange | None
    frequency: float | None
    unit: str

    @property
    def name(self) -> str:
        """What tells it from the scenario's others."""
        label = f"[{self.label}]" if self.label else ""
        return f"{self.text}{label} {self.predicate}"

    @property
    def predicate(self) -> str:
        """As the scenario writes it."""
        return f"{self.measure}_{self.comparison}" if self.measure else self.comparison


@dataclass(frozen=True, slots=True)
class Verdict:
    """What was measured: every value lies between ``low`` and ``high``, which may be equal."""

    expectation: Expectation
    low: float
    high: float
    passed: bool

    def __str__(self) -> str:
        asked = self.expectation
        name = f"{asked.text} ({asked.label})" if asked.label else asked.text
        limit = " to ".join(f"{value:g}" for value in asked.limit)
        unit = f" {asked.unit}" if asked.unit not in {"", "1"} else ""
        if math.isnan(self.low):
            found = "nothing in this window"
        elif self.low == self.high:
            found = f"{self.low:.6g}{unit}"
        else:
            found = f"{self.low:.6g} to {self.high:.6g}{unit}"
        return f"{name}: {asked.predicate} {limit}{unit}, measured {found}"

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        asked = self.expectation
        measured = None if math.isnan(self.low) else [self.low, self.high]
        return {
            "target": asked.text,
            "label": asked.label,
            "predicate": asked.predicate,
            "threshold": list(asked.limit) if asked.comparison == "within" else asked.limit[0],
            "measured": measured[0] if measured and self.low == self.high else measured,
            "unit": asked.unit,
            "passed": self.passed,
        }


def parse_expectations(scenario: Scenario, recorded: Mapping[str, str]) -> list[Expectation]:
    """The scenario's expectations, checked against what is recorded: signal name -> unit.

    Raises:
        InputErrors: every predicate, threshold, option or signal that cannot be, with its place.
    """
    found: list[Expectation] = []
    errors: list[InputError] = []
    for text, conditions in scenario.expect.items():
        for label, entries in _windows(conditions).items():
            path = ("expect", text, *((label,) if label else ()))
            try:
                found += _Parser(scenario, recorded, text, label, entries).parse()
            except (InputError, QuantityError) as error:
                errors.append(InputError(str(error), scenario.locate(path)))
    if errors:
        raise InputErrors(errors)
    return found


def evaluate(measured: Inspection, expectations: Sequence[Expectation]) -> list[Verdict]:
    """Measure and compare, each in its window."""
    return [_evaluate(measured, expectation) for expectation in expectations]


def _evaluate(measured: Inspection, asked: Expectation) -> Verdict:
    run = measured.run
    if asked.target is None:
        found = measured.value(asked.text, asked.window)
        low = high = math.nan if found is None else found
    else:
        first, last = asked.window or (0, run.ticks)
        window = (
            measured.window(asked.target, first, last)
            if asked.frequency is None
            else measure(run, asked.target, first, last, asked.frequency)
        )
        if window.rows == 0 or window.missing:
            low = high = math.nan
        elif asked.measure:
            low = high = MEASURES[asked.measure](window)
        else:
            low, high = window.minimum, window.maximum
    return Verdict(asked, low, high, COMPARISONS[asked.comparison](low, high, asked.limit))


def _windows(conditions: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """The named windows of a target, and what stands beside them as the one without a name."""
    named: dict[str, Mapping[str, Any]] = {
        key: cast("Mapping[str, Any]", value)
        for key, value in conditions.items()
        if isinstance(value, Mapping)
    }
    plain = {key: value for key, value in conditions.items() if key not in named}
    return ({"": plain} if plain or not named else {}) | named


@dataclass(frozen=True, slots=True)
class _Parser:
    scenario: Scenario
    recorded: Mapping[str, str]
    text: str
    label: str
    entries: Mapping[str, Any]

    def parse(self) -> list[Expectation]:
        target, unit = self._target()
        window = self._window()
        frequency = self.entries.get("frequency")
        if frequency is not None and not isinstance(frequency, int | float):
            raise InputError(f"frequency is a number in rad/s, not {show(frequency)}.")
        if frequency is not None and not 0 < frequency < math.inf:
            raise InputError(f"frequency is a number above 0 in rad/s, not {show(frequency)}.")
        predicates = {key: value for key, value in self.entries.items() if key not in OPTIONS}
        if not predicates:
            raise InputError(f"{self.text} expects nothing; write a predicate such as max_below.")
        found: list[Expectation] = []
        has_amplitude = False
        for key, threshold in predicates.items():
            name, comparison = self._predicate(key, of_signal=target is not None)
            if name == "amplitude" and frequency is None:
                raise InputError("an amplitude needs the frequency (rad/s) beside it.")
            has_amplitude |= name == "amplitude"
            dimension = _OWN_UNITS.get(name, unit)
            found.append(
                Expectation(
                    text=self.text,
                    target=target,
                    label=self.label,
                    measure=name,
                    comparison=comparison,
                    limit=_limit(key, comparison, threshold, dimension),
                    window=window,
                    frequency=frequency,
                    unit=dimension,
                )
            )
        if frequency is not None and not has_amplitude:
            raise InputError(
                "frequency has no effect: it is that of an amplitude, and none is expected."
            )
        return found

    def _target(self) -> tuple[Target | None, str]:
        if self.text in SCENARIO_MEASURES:
            return None, SCENARIO_MEASURES[self.text].unit
        if "." not in self.text:
            raise InputError(
                f"{self.text} is neither a signal nor a measure of the scenario."
                f"{did_you_mean(self.text, SCENARIO_MEASURES)}"
            )
        target = parse_target(self.text, self.recorded)
        units = {self.recorded[name] for name in target.signals}
        if len(units) > 1:
            raise InputError(f"{self.text} mixes the units {' and '.join(sorted(units))}.")
        return target, units.pop()

    def _window(self) -> TickRange | None:
        if "from" not in self.entries and "to" not in self.entries:
            return None
        rate, start = self.scenario.base_rate, self.scenario.start_tick
        begin, end = self.entries.get("from"), self.entries.get("to")
        first = 0 if begin is None else math.ceil(quantity(begin, "s") * rate) - start
        last = self.scenario.ticks
        if end is not None:
            last = math.floor(quantity(end, "s") * rate) + 1 - start
        if not 0 <= first < last or first >= self.scenario.ticks:
            whole = float(start / rate), float((start + self.scenario.ticks) / rate)
            written = whole[0] if begin is None else begin, whole[1] if end is None else end
            lasting = f"{whole[1] - whole[0]:g} s of the run"
            if start:
                lasting += f", from {whole[0]:g} s to {whole[1]:g} s"
            raise InputError(f"from {written[0]} to {written[1]} is no time within the {lasting}.")
        return first, last

    def _predicate(self, key: str, *, of_signal: bool) -> tuple[str, str]:
        name, _, comparison = key.rpartition("_")
        if comparison in COMPARISONS and (not name or (of_signal and name in MEASURES)):
            return name, comparison
        known = [*COMPARISONS, *OPTIONS]
        if of_signal:
            known += [f"{name}_{comparison}" for name in MEASURES for comparison in COMPARISONS]
        raise InputError(f"{key} is not a predicate.{did_you_mean(key, known)}")


def _limit(key: str, comparison: str, threshold: Any, unit: str) -> tuple[float, ...]:
    parts: list[Any] = (
        list(cast("Sequence[Any]", threshold))
        if isinstance(threshold, list | tuple)
        else [threshold]
    )
    wanted = 2 if comparison == "within" else 1
    if len(parts) != wanted or any(isinstance(part, bool) for part in parts):
        form = "[low, high]" if wanted == 2 else "one number"
        raise InputError(f"{key} takes {form}, not {show(threshold)}.")
    if not all(isinstance(part, int | float | str) for part in parts):
        raise InputError(f"{key} takes numbers, not {show(threshold)}.")
    limit = tuple(float(quantity(part, unit or "1")) for part in parts)
    if limit[0] > limit[-1]:
        raise InputError(f"{key}: the low end {parts[0]} lies above the high end {parts[1]}.")
    return limit
