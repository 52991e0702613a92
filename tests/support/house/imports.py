"""Who imports whom, read from the sources: every import counts, for types and late ones too."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
PACKAGES = ("cohaptic", "cosim", "hil", "fmus")
Graph = dict[str, set[str]]


def sources() -> dict[str, Path]:
    """Every module's file, by the module's name."""
    found: dict[str, Path] = {}
    for top in PACKAGES:
        for file in sorted((ROOT / top).rglob("*.py")):
            parts = file.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


def graph(files: dict[str, Path]) -> Graph:
    """The modules that each module imports."""
    return {module: _imports(module, file, files) for module, file in files.items()}


def _imports(module: str, file: Path, known: dict[str, Path]) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [name if name in known else node.module for name in names]
        else:
            continue
        for name in names:
            parts = name.split(".")
            reached = [".".join(parts[:end]) for end in range(len(parts), 0, -1)]
            found |= set(next(([each] for each in reached if each in known), []))
    return found - {module}


def circles(imports: Graph) -> list[list[str]]:
    """The sets of modules that import each other in a circle (Tarjan 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(module: str) -> None:
        index[module] = low[module] = len(index)
        stack.append(module)
        for other in sorted(imports[module]):
            if other not in index:
                visit(other)
                low[module] = min(low[module], low[other])
            elif other in stack:
                low[module] = min(low[module], index[other])
        if low[module] == index[module]:
            circle = stack[stack.index(module) :]
            del stack[stack.index(module) :]
            if len(circle) > 1:
                found.append(sorted(circle))

    for module in imports:
        if module not in index:
            visit(module)
    return found
