"""docs/scenarios.md from the bundled scenarios: ``python -m tests.support.guide.gallery``.

Its pictures are made by ``cohaptic scenarios --pictures docs/images/scenarios``.
"""

from __future__ import annotations

from pathlib import Path

from cosim.scenario.source.bundled import bundled_scenarios

DOCS = Path(__file__).parents[3] / "docs"
PAGE = DOCS / "scenarios.md"
PICTURES = DOCS / "images" / "scenarios"
HEAD = """# Bundled scenarios

What `cohaptic run NAME` runs, halfway through. `cohaptic scenarios` lists them, and
`cohaptic scenarios NAME` says where the file is; `cohaptic new FILE` writes a short scenario of
your own that stands on one of them.
"""


def gallery() -> str:
    """The page."""
    parts = [HEAD]
    for each in bundled_scenarios():
        picture = f"images/scenarios/{each.name}.webp"
        shown = f"![{each.title}]({picture})\n\n" if (DOCS / picture).is_file() else ""
        parts.append(f"## {each.name}\n\n{each.title}.\n\n{shown}{each.description}\n")
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(gallery(), encoding="utf-8")
