"""One rule of the conformance suite, and what became of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

B = TypeVar("B")
"""The bench of what is tried: a board's, or a sensor's."""


class Need(StrEnum):
    """What a rule cannot be tried without."""

    OUTPUT = "output"
    """The output stage on, at zero or a hundredth of a newton metre: ``--enable-output``."""
    EMULATOR = "emulator"
    """Something that only an emulator can tell or do."""


class Conformity(StrEnum):
    """What became of a rule."""

    KEPT = "kept"
    BROKEN = "broken"
    NOT_TRIED = "not tried"


@dataclass(frozen=True, slots=True)
class ConformRule(Generic[B]):
    """``check`` raises ``NotConform`` or ``NotTried``; where it returns, the rule is kept."""

    name: str
    claim: str
    check: Callable[[B], None]
    needs: frozenset[Need] = frozenset()


@dataclass(frozen=True, slots=True)
class RuleResult:
    """What became of one rule, and why."""

    name: str
    claim: str
    outcome: Conformity
    sentence: str
