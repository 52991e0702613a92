"""No number of a hand stands without a publication that docs/people.md lists, or "assumed"."""

from __future__ import annotations

import re
from math import sqrt
from pathlib import Path

import pytest

from fmus.operator.hands import HANDS, NamedHand, SourcedValue
from fmus.operator.variables import MODEL
from fmus.table import ModelVariable

PAGE = (Path(__file__).parents[3] / "docs" / "people.md").read_text("utf-8")
CITED = re.compile(r"(?P<authors>[^:;,]*[A-ZÖ][^()]*) \((?P<year>(?:19|20)\d\d)\)")
BY_NAME = {hand.name: hand for hand in HANDS}


def references() -> list[str]:
    """The page's list of sources, each on one line."""
    listed = PAGE.split("## Sources")[1]
    return [" ".join(one.split()) for one in re.split(r"^- ", listed, flags=re.MULTILINE)[1:]]


def unsourced(number: SourcedValue) -> bool:
    """Whether it neither is assumed nor cites what the page lists."""
    return not number.is_assumed and not cited(number.source)


def cited(source: str) -> list[str]:
    """The references that a source names, each of which has to be on the page."""
    found: list[str] = []
    for one in CITED.finditer(source):
        last = re.findall(r"[A-ZÖ][\w-]+", one["authors"])[-1]
        listed = [line for line in references() if last in line and one["year"] in line]
        assert len(listed) == 1, f"{one[0]} is {len(listed)} times under Sources of docs/people.md"
        found += listed
    return found


@pytest.mark.parametrize("hand", HANDS, ids=lambda hand: hand.name)
def test_a_number_is_published_or_assumed(hand: NamedHand) -> None:
    assert {value for value in hand.row if value} <= {each.value for each in hand.numbers}
    for number in hand.numbers:
        assert not unsourced(number), f"{number.value:g} of {hand.name}: {number.source}"
        cited(number.source)
        assert f"{number.value:g} " in hand.description
        assert f"({number.source})" in hand.description


def test_a_number_without_either_is_noticed() -> None:
    assert unsourced(SourcedValue(1.0, "what everybody knows"))
    with pytest.raises(AssertionError, match="is 0 times under Sources"):
        cited("Nobody (1999)")


def test_only_the_measured_arm_is_all_published() -> None:
    published = {h.name for h in HANDS if not any(each.is_assumed for each in h.numbers)}
    assert published == {"arm"}


def test_what_is_said_to_be_derived_is() -> None:
    arm = BY_NAME["arm"]
    for name, factor in (("arm_soft", 0.5), ("arm_stiff", 2.0)):
        other = BY_NAME[name]
        assert other.stiffness.value == pytest.approx(factor * arm.stiffness.value)
        assert other.damping.value == pytest.approx(sqrt(factor) * arm.damping.value, rel=1e-3)
        assert other.mass == arm.mass
    for newtons in (1, 2, 3):
        grip = BY_NAME[f"grip_{newtons}_newton"]
        assert (grip.stiffness, grip.damping, grip.mass) == (arm.stiffness, arm.damping, arm.mass)
        assert grip.grip_stiffness is not None
        assert grip.grip_stiffness.value == 300.0 * newtons


@pytest.mark.parametrize("name", ["hand_mass", "grip_stiffness", "grip_damping"])
def test_what_a_grip_of_ones_own_starts_with_is_said_to_be_assumed(name: str) -> None:
    found = [v for v in MODEL.variables if isinstance(v, ModelVariable) and v.name == name]
    assert len(found) == 1
    assert "assumed" in found[0].description
