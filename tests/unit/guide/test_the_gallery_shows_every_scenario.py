"""docs/scenarios.md says of every bundled scenario what its file says, and shows what moves."""

from __future__ import annotations

from cosim.scenario.source.bundled import bundled_scenarios
from tests.support.guide.gallery import PAGE, PICTURES, gallery


def test_the_page_is_what_the_files_say() -> None:
    made = "python -m tests.support.guide.gallery makes it anew"
    assert PAGE.read_text(encoding="utf-8") == gallery(), made


def test_there_is_a_picture_of_each_and_of_nothing_else() -> None:
    names = {each.name for each in bundled_scenarios()}
    pictures = {
        file.relative_to(PICTURES).with_suffix("").as_posix() for file in PICTURES.rglob("*.webp")
    }
    assert pictures == names, "cohaptic scenarios --pictures docs/images/scenarios makes them"
