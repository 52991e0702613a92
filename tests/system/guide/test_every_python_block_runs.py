"""The Python that a page shows runs as it stands there, one block after the other."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.command import cohaptic
from tests.support.guide.blocks import PAGES, ROOT, blocks_of

ELSEWHERE = {
    "CONTRIBUTING.md": "test_the_recipe_of_a_python_component_works",
    "docs/driver.md": "tests/system/drivers/test_a_driver_of_ones_own_is_one_folder",
    "docs/texts.md": "parts of classes; test_texts_travel_like_numbers has whole ones",
    "docs/time.md": "tests/unit/guide/test_time_passes_as_its_page_says",
}
"""By page: where its Python is run instead."""
SHOWN = {
    page.relative_to(ROOT).as_posix(): found
    for page in PAGES
    if (found := [text for language, text in blocks_of(page) if language == "python"])
}
SAID = re.compile(r"^print\(.*\)  # (.*)$", re.MULTILINE)
"""What a line prints, where the page says it."""


def test_each_page_is_run_here_or_elsewhere() -> None:
    assert set(ELSEWHERE) <= set(SHOWN)
    assert len(SHOWN) > len(ELSEWHERE)


@pytest.mark.slow
@pytest.mark.parametrize("page", sorted(set(SHOWN) - set(ELSEWHERE)))
def test_a_pages_python_runs(page: str, tmp_path: Path) -> None:
    if page == "docs/record.md":  # it reads a run
        run = "runs/two_users_box-1"
        done = cohaptic("run", "two_users_box", "--no-figure", "--no-report", folder=tmp_path)
        assert done.returncode == 0, done.stderr
        (tmp_path / "run.h5").symlink_to(tmp_path / run / "run.h5")
    script = tmp_path / "page.py"
    script.write_text("\n\n".join(SHOWN[page]), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, script.name], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    said = SAID.findall(script.read_text("utf-8"))
    assert [line for line in done.stdout.splitlines() if line in said] == said
