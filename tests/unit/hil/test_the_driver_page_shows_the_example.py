"""docs/driver.md shows the very files of the example that the tests install and run."""

from __future__ import annotations

import os
import re
from pathlib import Path

from hil.device.driver import Driver
from hil.setup.driver_facts import DriverFacts

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs/driver.md"
EXAMPLE = ROOT / "tests/outside/lab_board"
BLOCK = re.compile(r"(<!-- file (\S+) -->\n).*?(<!-- end of file -->)", re.DOTALL)


def shown(found: re.Match[str]) -> str:
    file = EXAMPLE / found[2]
    language = {".toml": "toml", ".py": "python"}[file.suffix]
    return f"{found[1]}\n```{language}\n{file.read_text('utf-8')}```\n\n{found[3]}"


def test_the_page_has_the_files_of_the_example():
    page = PAGE.read_text("utf-8")
    written = BLOCK.sub(shown, page)
    if os.environ.get("COHAPTIC_WRITE_DOCS"):
        PAGE.write_text(written, "utf-8")
        return
    assert page == written, "run this test with COHAPTIC_WRITE_DOCS=1"
    files = {found[2] for found in BLOCK.finditer(page)}
    assert files == {"pyproject.toml"} | {
        f"lab_board/{file.name}" for file in EXAMPLE.glob("lab_board/[!_]*.py")
    }


def test_the_page_names_every_fact_of_a_driver():
    page = PAGE.read_text("utf-8")
    names = {name for name in vars(DriverFacts) if not name.startswith("_")} | {"driver"}
    rows = page.partition("## What its class may say")[2]
    assert {name for name in names if f"`{name}`" not in rows} == {"in_process"}
    for call in re.findall(r"world\.boundary|zero_confirmed|bus_use", page):
        assert hasattr(Driver, call) or call in {"world.boundary", "zero_confirmed"}
