"""The version stands in pyproject.toml; the changelog and the ratios that are kept know it."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[3]
VERSION: str = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]


def test_the_changelog_has_the_version_below_what_is_unreleased() -> None:
    headings = re.findall(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M)
    released = [heading for heading in headings if heading != "Unreleased"]
    assert released[0] == VERSION
    assert "Unreleased" not in headings[1:]
    assert released == sorted(released, key=lambda name: [*map(int, name.split("."))], reverse=True)


def test_the_ratios_of_the_version_are_kept() -> None:
    kept = json.loads((ROOT / "bench" / "ratios" / f"{VERSION}.json").read_text("utf-8"))
    assert kept


def test_the_lock_is_of_this_version() -> None:
    locked = tomllib.loads((ROOT / "uv.lock").read_text("utf-8"))["package"]
    (own,) = [each["version"] for each in locked if each["name"] == "cohaptic"]
    assert own == VERSION
