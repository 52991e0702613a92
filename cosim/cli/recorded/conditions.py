"""What ``cohaptic runs --where`` asks of a run: a name, a comparison, a value."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import QuantityError, exact, quantity, split_quantity
from cosim.base.quantities.units import UnitError, parse_unit
from cosim.base.suggest import did_you_mean

if TYPE_CHECKING:
    from cosim.base.document.node import Node

COMPARISONS = {
    ">=": operator.ge,
    "<=": operator.le,
    "!=": operator.ne,
    "=": operator.eq,
    ">": operator.gt,
    "<": operator.lt,
}
OWN = ("scenario", "status", "started", "simulated_time")
"""What every run has beside its measures."""
STATUS = {"good": 0, "failed": 1, "refused": 2}


@dataclass(frozen=True, slots=True)
class Condition:
    """One ``--where``."""

    text: str
    name: str
    sign: str
    wanted: str

    @staticmethod
    def read(text: str) -> Condition:
        """From ``NAME=VALUE``.

        Raises:
            InputError: it is not written so.
        """
        for sign in COMPARISONS:
            name, found, value = text.partition(sign)
            if found and name.strip() and value.strip():
                return Condition(text, name.strip(), sign, value.strip())
        raise InputError(f"--where {text}: write NAME=VALUE, such as drift<0.002 or vr_a.mass=0.4.")

    def holds(self, runs: Sequence[Mapping[str, Any]], folder: Path) -> list[bool]:
        """Of which of the runs in ``folder`` it holds.

        Raises:
            InputError: none of them has anything of that name, or what it has cannot be compared
                like this.
        """
        from cosim.report.measures import SCENARIO_MEASURES

        if self.name in SCENARIO_MEASURES:
            self._number()
        found = [self._found(facts) for facts in runs]
        known = {*OWN, *SCENARIO_MEASURES}
        if runs and self.name not in known and all(value is None for value in found):
            raise InputError(
                f"--where {self.text}: no run in {folder} has '{self.name}', neither measured nor "
                f"in its scenario.{did_you_mean(self.name, known, listed=0)}"
            )
        return [value is not None and self._holds(value) for value in found]

    def _found(self, facts: Mapping[str, Any]) -> Any:
        if self.name in facts["measures"]:
            return facts["measures"][self.name]
        if self.name in OWN:
            return facts[self.name]
        return _written(Path(facts["folder"]), self.name)

    def _holds(self, actual: Any) -> bool:
        if self.name == "status" and self.wanted in STATUS:
            return self._compares(actual, STATUS[self.wanted])
        if isinstance(actual, bool):
            if self.wanted not in {"true", "false"}:
                raise self._refusal("is true or false")
            return self._compares(actual, self.wanted == "true", ordered=False)
        if isinstance(actual, int | float):
            wanted = self._number()
            return self._compares(exact(actual) if math.isfinite(actual) else actual, wanted)
        if self.name == "started":
            return self._compares(str(actual)[: len(self.wanted)], self.wanted)
        return self._compares(_plain(actual), self.wanted, ordered=False)

    def _compares(self, one: Any, other: Any, *, ordered: bool = True) -> bool:
        if not ordered and self.sign not in {"=", "!="}:
            raise self._refusal("is compared by = and !=")
        return bool(COMPARISONS[self.sign](one, other))

    def _number(self) -> Fraction:
        """What is wanted, in SI units, or in that of the measure."""
        from cosim.report.measures import SCENARIO_MEASURES

        try:
            if self.name == "simulated_time":
                return quantity(self.wanted, "s")
            if self.name in SCENARIO_MEASURES:
                return quantity(self.wanted, SCENARIO_MEASURES[self.name].unit or "1")
            number, spelling = split_quantity(self.wanted)
            unit = None if spelling is None else parse_unit(spelling)
        except (QuantityError, UnitError) as error:
            raise self._refusal(f"is a number: {error}") from None
        return number if unit is None else number * unit.factor + unit.offset

    def _refusal(self, what: str) -> InputError:
        return InputError(f"--where {self.text}: {self.name} {what}")


def _plain(value: Any) -> str:
    """As YAML has it in one line."""
    if isinstance(value, list):
        items = cast("list[Any]", value)
        return f"[{', '.join(_plain(each) for each in items)}]"
    return str(value)


@cache
def _read(file: Path, written: int) -> Node:
    """A scenario, once for all conditions; ``written`` is when (ns)."""
    from cosim.base.document.yaml_reader import parse_yaml

    del written
    return parse_yaml(file.read_text(encoding="utf-8"), str(file))


def _written(folder: Path, name: str) -> Any:
    """What stands at a place in the resolved scenario; ``None`` where nothing does."""
    from cosim.record.reader import SCENARIO_FILE

    file = folder / SCENARIO_FILE
    if not file.is_file():
        return None
    root = _read(file, file.stat().st_mtime_ns)
    first, _, rest = name.partition(".")
    for path in (
        name.split("."),
        ["components", first, "parameters", rest],
        ["components", first, *rest.split(".")],
        ["channels", first, *rest.split(".")],
    ):
        keys = tuple(path)
        node, depth = root.find(keys)
        if depth == len(keys) and not node.is_mapping:
            return node.plain()
    return None
