"""Hold, linear and intent on hands that nobody fitted to; the table of docs/people.md."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from cosim.analysis.intent.compare import DELAYS, errors
from cosim.analysis.intent.filter import Tuning
from cosim.analysis.intent.moves import CREEPING, QUICK, SLOW, made
from fmus.operator.hands import HANDS
from tests.support.guide.written import hold_between

PAGE = Path(__file__).parents[3] / "docs" / "people.md"
TREMOR = 1e-4
KINDS = {
    "quick, 0.25 to 0.7 s": (QUICK, 0.0),
    "slow, 0.8 to 2 s": (SLOW, 0.0),
    "slow, with a tremor of 0.1 mm": (SLOW, TREMOR),
    "creeping, 3 to 6 s": (CREEPING, 0.0),
}


@cache
def judged(kind: str) -> dict[str, dict[int, float]]:
    duration, tremor = KINDS[kind]
    hands = made(duration, tremor=tremor, tracks=6, seed=77, length=2.5)
    return errors(hands, Tuning.default())


def test_intent_wins_on_quick_reaches_and_linear_where_hands_creep() -> None:
    quick, creeping = judged("quick, 0.25 to 0.7 s"), judged("creeping, 3 to 6 s")
    for delay in DELAYS:
        assert quick["intent"][delay] < 0.5 * quick["linear"][delay] < 0.5 * quick["hold"][delay]
        assert creeping["linear"][delay] < creeping["intent"][delay] < creeping["hold"][delay]


def test_the_error_grows_with_the_delay() -> None:
    for kind in KINDS:
        for row in judged(kind).values():
            assert list(row.values()) == sorted(row.values())


def test_a_hand_that_only_drifts_is_guessed_as_it_is() -> None:
    """At rest, counts of the encoder are all that is left of the error."""
    hands = made((50.0, 60.0), tracks=2, length=1.0)
    hands = type(hands)(0 * hands.position + 0.1, 0 * hands.velocity, hands.period, hands.ratio)
    assert max(errors(hands, Tuning.default())["intent"].values()) < 1e-9


def test_the_page_has_these_errors() -> None:
    lines = ["| hands | predictor |" + "".join(f" n = {delay} |" for delay in DELAYS)]
    lines.append("|---|---|" + "---|" * len(DELAYS))
    for kind in KINDS:
        for name, row in judged(kind).items():
            values = " | ".join(f"{1e3 * value:.2f}" for value in row.values())
            lines.append(f"| {kind} | {name} | {values} |")
    hold_between(PAGE, "<!-- errors -->", "<!-- /errors -->", "\n".join(lines))


def test_the_page_has_every_hand() -> None:
    lines = ["| `impedance` | what it is |", "|---|---|"]
    lines += [f"| `{hand.name}` | {hand.description} |" for hand in HANDS]
    hold_between(PAGE, "<!-- hands -->", "<!-- /hands -->", "\n".join(lines))


@pytest.mark.parametrize("kind", ["slow, 0.8 to 2 s", "slow, with a tremor of 0.1 mm"])
def test_what_the_page_says_of_slow_hands_is_so(kind: str) -> None:
    found = judged(kind)
    for delay in DELAYS:
        assert 0.45 < found["intent"][delay] / found["linear"][delay] < 0.8
