"""All rules, tried one after the other on one board."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from difflib import get_close_matches

from cosim.base.errors import CohapticError, InputError
from hil.setup.conform.bench import ConformBench
from hil.setup.conform.errors import NotTried
from hil.setup.conform.frame_rules import FRAME_RULES
from hil.setup.conform.line_rules import LINE_RULES
from hil.setup.conform.motion_rules import MOTION_RULES
from hil.setup.conform.output_rules import OUTPUT_RULES
from hil.setup.conform.rule import B, Conformity, ConformRule, Need, RuleResult

RULES: tuple[ConformRule[ConformBench], ...] = (
    *LINE_RULES,
    *MOTION_RULES,
    *FRAME_RULES,
    *OUTPUT_RULES,
)


def chosen(names: Sequence[str], rules: Sequence[ConformRule[B]]) -> list[ConformRule[B]]:
    """Those of ``rules`` with these names; all of them for none.

    Raises:
        InputError: there is no such rule.
    """
    known = {rule.name: rule for rule in rules}
    for name in names:
        if name not in known:
            close = get_close_matches(name, known, 1)
            hint = f"did you mean '{close[0]}'?" if close else f"there are {', '.join(known)}"
            raise InputError(f"there is no rule '{name}'; {hint}")
    return [rule for rule in rules if not names or rule.name in names]


def conform(
    bench: ConformBench, rules: Sequence[ConformRule[ConformBench]] = RULES
) -> Iterator[RuleResult]:
    """What becomes of each rule, as soon as it is known."""
    for rule in rules:
        outcome, sentence = _try(bench, rule)
        yield RuleResult(rule.name, rule.claim, outcome, sentence)


def _try(bench: ConformBench, rule: ConformRule[ConformBench]) -> tuple[Conformity, str]:
    if Need.OUTPUT in rule.needs and bench.permission is None:
        return Conformity.NOT_TRIED, "its output stage would be on: give --enable-output"
    if Need.EMULATOR in rule.needs and bench.control is None:
        return Conformity.NOT_TRIED, "only an emulator can tell"
    try:
        rule.check(bench)
    except NotTried as why:
        return Conformity.NOT_TRIED, str(why)
    except CohapticError as error:
        return Conformity.BROKEN, str(error)
    return Conformity.KEPT, ""
