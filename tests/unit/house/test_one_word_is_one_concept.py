"""No two public classes have one name: a reader who meets it knows which one is meant."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parents[3]
PACKAGES = ("cohaptic", "cosim", "hil", "fmus")
MOST_FILES = 17
"""About fifteen files a folder; ``__init__.py`` and a straggler included."""


def public_classes() -> dict[str, list[str]]:
    found: dict[str, list[str]] = defaultdict(list)
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    found[node.name].append(str(path.relative_to(ROOT)))
    return found


def test_no_two_public_classes_have_one_name() -> None:
    assert {name: files for name, files in public_classes().items() if len(files) > 1} == {}


def test_no_folder_holds_more_than_a_reader_can_keep_in_mind() -> None:
    crowded: dict[str, int] = {}
    for package in PACKAGES:
        for folder in (ROOT / package).rglob("*"):
            if folder.is_dir() and "musl" not in folder.name and folder.name != "_built":
                count = sum(path.suffix in {".py", ".c", ".h"} for path in folder.iterdir())
                if count > MOST_FILES:
                    crowded[str(folder.relative_to(ROOT))] = count
    assert crowded == {}
