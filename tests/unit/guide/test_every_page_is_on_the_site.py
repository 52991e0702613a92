"""Every page of docs/ stands once in the site's navigation, and the site's faults end its build."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[3]
SITE = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
WITHIN = {"decisions/README.md"}
"""Pages in folders of docs/; what stands in ``reference/`` and ``notebooks/`` the site makes."""


def test_every_page_stands_once_in_the_navigation() -> None:
    named = re.findall(r"^ +- (?:[^:\n]+: )?([\w/-]+\.md)$", SITE.partition("\nnav:\n")[2], re.M)
    own = [page for page in named if not page.startswith(("reference/", "notebooks/"))]
    pages = [page.name for page in (ROOT / "docs").glob("*.md")]
    assert sorted(own) == sorted([*pages, *WITHIN])


def test_a_page_left_out_ends_the_build() -> None:
    assert re.search(r"^strict: true$", SITE, re.M)
    build = next(
        line for line in (ROOT / ".ci" / "run").read_text().splitlines() if "mkdocs" in line
    )
    # A quiet build hears no warnings, so that its strictness never meets any.
    assert build.endswith("mkdocs build")
