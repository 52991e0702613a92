"""Links of pages lead to files, in the repository and, as the site has them, to its pages."""

from __future__ import annotations

import re
from pathlib import Path
from posixpath import normpath
from types import SimpleNamespace

import pytest

from tests.support.guide import site

ROOT = Path(__file__).parents[3]
WRITTEN = [
    *sorted(ROOT.glob("*.md")),
    *sorted(ROOT.glob("docs/**/*.md")),
    *sorted(ROOT.glob("fmus/*/README.md")),
]
LINK = re.compile(r"\[[^\]]*\]\(([^)\s#]+)(?:#[^)]*)?\)")
CODE = re.compile(r"^ *```.*?^ *```|`[^`\n]*`", re.DOTALL | re.MULTILINE)
MADE = {"reference/commands.md", "reference/python.md", "reference/models.md"}
MODELS = {f"reference/models/{file.parent.name}.md": file for file in ROOT.glob("fmus/*/README.md")}
NOTEBOOKS = {f"notebooks/{file.stem}.md" for file in ROOT.glob("docs/notebooks/*.py")}
PAGES = {
    **{
        file.relative_to(ROOT / "docs").as_posix(): file
        for file in sorted(ROOT.glob("docs/**/*.md"))
    },
    **MODELS,
}


def links(text: str) -> list[str]:
    return [each for each in LINK.findall(CODE.sub("", text)) if "://" not in each]


@pytest.mark.parametrize("page", WRITTEN, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_a_pages_links_are_files(page: Path) -> None:
    missing = [each for each in links(page.read_text("utf-8")) if not (page.parent / each).exists()]
    assert missing == []


@pytest.mark.parametrize("place", PAGES)
def test_on_the_site_they_are_pages(place: str) -> None:
    """What leads out of docs/ is text there, or a model's page."""
    page = SimpleNamespace(file=SimpleNamespace(src_uri=place))
    shown = site.on_page_markdown(PAGES[place].read_text("utf-8"), page, None, None)
    here = place.rpartition("/")[0]
    for target in links(shown):
        led = normpath(f"{here}/{target}" if here else target)
        known = led in MADE | MODELS.keys() | NOTEBOOKS
        assert known or (ROOT / "docs" / led).is_file(), f"{place}: {target}"
