"""``expect:`` of a scenario, read against what is recorded: what cannot be told is refused."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from cosim.base.document.show import show
from cosim.base.errors import InputError, InputErrors
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.base.recording import Column, RecordGroup
from cosim.base.suggest import did_you_mean
from cosim.report.expectation import COMPARISONS, OPTIONS, Expectation
from cosim.report.measures import SCENARIO_MEASURES, TickRange
from cosim.report.platform import find_platform
from cosim.report.target import Target, parse_target
from cosim.report.verdict.lack import too_few
from cosim.report.window import MEASURES, can_not_tell
from cosim.scenario import Scenario


def parse_expectations(scenario: Scenario, groups: Sequence[RecordGroup]) -> list[Expectation]:
    """The scenario's expectations, checked against the groups that are recorded.

    Raises:
        InputErrors: every predicate, threshold, option or signal that cannot be, every window
            without what its measure takes, and what could not fail, with its place.
    """
    recorded = {
        column.name: _Recorded(column, group.period)
        for group in sorted(groups, key=lambda group: -group.period)  # of several rates the fastest
        for column in group.columns
    }
    found: list[Expectation] = []
    errors: list[InputError] = []
    for text, conditions in scenario.expect.items():
        for label, entries in _windows(conditions).items():
            path = ("expect", text, *((label,) if label else ()))
            try:
                found += _Parser(scenario, recorded, text, label, entries, path).parse()
            except InputErrors as several:
                errors += several.errors
            except (InputError, QuantityError) as error:
                errors.append(InputError(str(error), scenario.locate(path)))
    if errors:
        raise InputErrors(errors)
    return found


@dataclass(frozen=True, slots=True)
class _Recorded:
    """A column, and every how many base ticks it has a row."""

    column: Column
    period: int


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
    recorded: Mapping[str, _Recorded]
    text: str
    label: str
    entries: Mapping[str, Any]
    path: tuple[str, ...]

    def parse(self) -> list[Expectation]:
        target, unit = self._target()
        window = self._window()
        frequency = self._frequency()
        predicates = {key: value for key, value in self.entries.items() if key not in OPTIONS}
        if not predicates:
            raise InputError(f"{self.text} expects nothing; write a predicate such as max_below.")
        if frequency is not None and not any(key.startswith("amplitude_") for key in predicates):
            raise InputError(
                "frequency has no effect: it is that of an amplitude, and none is expected."
            )
        found: list[Expectation] = []
        errors: list[InputError] = []
        for key, threshold in predicates.items():
            try:
                name, comparison = self._predicate(key, of_signal=target is not None)
                own = MEASURES[name].unit if name else None
                dimension = unit if own is None else own
                limit = _limit(key, comparison, threshold, dimension)
                self._could_fail(key, name, comparison, limit, target)
                self._has_samples(name, target, window, frequency)
            except (InputError, QuantityError) as error:
                errors.append(InputError(str(error), self.scenario.locate((*self.path, key))))
                continue
            found.append(
                Expectation(
                    text=self.text,
                    target=target,
                    label=self.label,
                    measure=name,
                    comparison=comparison,
                    limit=limit,
                    window=window,
                    until=window[1] if window is not None and "to" in self.entries else None,
                    frequency=frequency,
                    unit=dimension,
                )
            )
        if errors:
            raise InputErrors(errors)
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
        if target.plus == target.minus:
            raise InputError(f"{self.text} is 0 whatever happens: both sides are the same.")
        units = {self.recorded[name].column.unit or "" for name in target.signals}
        if len(units) > 1:
            raise InputError(f"{self.text} mixes the units {' and '.join(sorted(units))}.")
        return target, units.pop()

    def _signals(self, target: Target | None) -> list[str]:
        """What is looked at: of a measure of the scenario, each signal by itself."""
        if target is not None:
            return list(target.signals)
        columns = {name: each.column for name, each in self.recorded.items()}
        return list(SCENARIO_MEASURES[self.text].reads(find_platform(columns)))

    def _frequency(self) -> float | None:
        frequency = self.entries.get("frequency")
        if frequency is None:
            return None
        if not isinstance(frequency, int | float):
            raise InputError(f"frequency is a number in rad/s, not {show(frequency)}.")
        if not 0 < frequency < math.inf:
            raise InputError(f"frequency is a number above 0 in rad/s, not {show(frequency)}.")
        return frequency

    def _could_fail(
        self,
        key: str,
        name: str,
        comparison: str,
        limit: tuple[float, ...],
        target: Target | None,
    ) -> None:
        """Refuse what is met by all that could ever be measured."""
        least, most = -math.inf, math.inf
        if target is None:
            least, most = 0.0, SCENARIO_MEASURES[self.text].most
        elif name and (own := MEASURES[name].least) is not None:
            least = own
        elif target.is_norm:
            least = 0.0
        if COMPARISONS[comparison](least, most, limit):
            what = self.text if target is None else f"the {name or 'value'} of {target.text}"
            between = "" if most == math.inf else f" and at most {most:g}"
            raise InputError(f"{key} cannot fail: {what} is at least {least:g}{between}.")

    def _has_samples(
        self, name: str, target: Target | None, window: TickRange | None, frequency: float | None
    ) -> None:
        """Refuse a window in which too few rows lie, as far as the plan tells."""
        if name == "amplitude" and frequency is None:
            raise InputError("an amplitude needs the frequency (rad/s) beside it.")
        first, last = window or (0, self.scenario.ticks)
        last = min(last, self.scenario.ticks)
        signals = self._signals(target)
        if not signals:
            raise InputError(
                f"nothing that is recorded tells {self.text}: "
                f"{SCENARIO_MEASURES[self.text].description}."
            )
        periods = [self.recorded[signal].period for signal in signals]
        if target is None:
            samples, period = SCENARIO_MEASURES[self.text].samples, max(periods)
            target = Target(signals[periods.index(period)], ())
        else:
            samples, period = MEASURES[name].samples if name else 1, min(periods)
        rows = -(-last // period) - -(-first // period)
        if rows < samples:
            every = f", recorded every {period} ticks" if period > 1 else ""
            raise InputError(f"this window holds {too_few(target, rows, samples)}{every}.")
        if name == "amplitude" and frequency is not None:
            step = float(period / self.scenario.base_rate)
            if reason := can_not_tell(frequency, (rows - 1) * step, step):
                raise InputError(f"this window tells no amplitude: {reason}.")

    def _window(self) -> TickRange | None:
        if "from" not in self.entries and "to" not in self.entries:
            return None
        rate, start = self.scenario.base_rate, self.scenario.start_tick
        begin, end = self.entries.get("from"), self.entries.get("to")
        first = 0 if begin is None else math.ceil(quantity(begin, "s") * rate) - start
        last = self.scenario.ticks
        if end is not None:
            last = math.floor(quantity(end, "s") * rate) + 1 - start
        whole = float(start / rate), float((start + self.scenario.ticks) / rate)
        lasting = f"{whole[1] - whole[0]:g} s of the run"
        if start:
            lasting += f", from {whole[0]:g} s to {whole[1]:g} s"
        if not 0 <= first < last or first >= self.scenario.ticks:
            written = whole[0] if begin is None else begin, whole[1] if end is None else end
            raise InputError(f"from {written[0]} to {written[1]} is no time within the {lasting}.")
        if last > self.scenario.ticks + 1:
            raise InputError(
                f"to {end} is beyond the {lasting}; without 'to' the window lasts to its end."
            )
        return first, min(last, self.scenario.ticks)

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
