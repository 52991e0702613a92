"""Bytes below sessions, sessions below streams; a measurement stands beside the streams."""

from __future__ import annotations

import ast
from pathlib import Path

import cosim.link

MAY_IMPORT = {
    "wire": set(),
    "session": {"wire"},
    "stream": {"session", "wire"},
    "netchar": {"session", "wire"},
}


def test_no_part_imports_one_above_it() -> None:
    found: dict[str, set[str]] = {part: set() for part in MAY_IMPORT}
    for file in Path(cosim.link.__file__).parent.glob("*/*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("cosim.link."):
                found[file.parent.name].add(node.module.split(".")[2])
    assert {part: found[part] - {part} for part in found} == MAY_IMPORT
