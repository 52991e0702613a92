"""Notebooks in the percent format, run cell by cell: ``python notebooks.py FILE`` prints what came.

Needs nothing but Python, so that it runs beside an installed package, too.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parents[3] / "docs" / "notebooks"
_CELL = re.compile(r"^# %%(.*)$", re.MULTILINE)


def files() -> list[Path]:
    """Every notebook, in the order of the site."""
    return [FOLDER / f"{name}.py" for name in ("first_run", "sweep_and_theory", "own_parts")]


def cells_of(file: Path) -> list[tuple[str, str]]:
    """Kind (``markdown`` or ``code``) and text of each cell; what is before the first is none."""
    _, *parts = _CELL.split(file.read_text(encoding="utf-8"))
    found: list[tuple[str, str]] = []
    for head, body in zip(parts[::2], parts[1::2], strict=True):
        if "[markdown]" in head:
            lines = (re.sub(r"^# ?", "", line) for line in body.strip().splitlines())
            found.append(("markdown", "\n".join(lines)))
        else:
            found.append(("code", body.strip()))
    return found


def executed(file: Path, python: str = sys.executable) -> list[dict[str, str]]:
    """Kind, text and output of each cell, run by ``python`` in an empty folder.

    Raises:
        RuntimeError: a cell failed; with what was said.
    """
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [python, __file__, str(file)], cwd=folder, capture_output=True, text=True, check=False
        )
    if done.returncode:
        raise RuntimeError(f"{file.name}: {done.stderr}")
    return json.loads(done.stdout)


def page_of(file: Path) -> str:
    """The notebook as a page: text, code, and what came of it."""
    parts: list[str] = []
    for cell in executed(file):
        if cell["kind"] == "markdown":
            parts.append(cell["text"])
        else:
            parts.append(f"```python\n{cell['text']}\n```")
            if cell["output"].strip():
                parts.append(f"```text\n{cell['output'].rstrip()}\n```")
    parts.append(f"This page is a notebook: [{file.name}]({file.name}) in the percent format.")
    return "\n\n".join(parts) + "\n"


def _run(file: Path) -> list[dict[str, str]]:
    sys.path.pop(0)  # this file's folder: nothing of the checkout
    # Classes of a cell belong to a module, as those of a notebook do.
    names: dict[str, Any] = vars(sys.modules["__main__"])
    found: list[dict[str, str]] = []
    for kind, text in cells_of(file):
        output = io.StringIO()
        if kind == "code":
            with contextlib.redirect_stdout(output):
                _cell(text, names)
        found.append({"kind": kind, "text": text, "output": output.getvalue()})
    return found


def _cell(text: str, names: dict[str, Any]) -> None:
    body = ast.parse(text).body
    last = body.pop() if body and isinstance(body[-1], ast.Expr) else None
    exec(compile(ast.Module(body, []), "cell", "exec"), names)
    if isinstance(last, ast.Expr):
        value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
        if value is not None:
            print(repr(value))


if __name__ == "__main__":
    print(json.dumps(_run(Path(sys.argv[1]))))
