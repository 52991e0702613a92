"""The table of ARCHITECTURE.md as contracts.

``python -m tests.support.house.contracts`` writes them into pyproject.toml.

The table is the only place to say who may import whom. A package may import itself and what its row
names, directly; what stands in the last column it may not reach even through others.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "ARCHITECTURE.md"
PROJECT = ROOT / "pyproject.toml"
BEGIN, END = "# Contracts: begin (written from ARCHITECTURE.md)", "# Contracts: end"
_HEAD = "| package | may import | never, even through others |"
_NAME = re.compile(r"`([\w.]+)`")


@dataclass(frozen=True)
class Row:
    """One package of the table; ``allowed`` is ``None`` where it may import everything."""

    package: str
    allowed: tuple[str, ...] | None
    never: tuple[str, ...]


def rows() -> list[Row]:
    """The table, from the top floor down."""
    lines = PAGE.read_text(encoding="utf-8").split(_HEAD, 1)[1].splitlines()[2:]
    found: list[Row] = []
    for line in lines:
        if not line.startswith("|"):
            break
        package, allowed, never = (cell.strip() for cell in line.strip("|").split("|"))
        found.append(
            Row(
                _NAME.findall(package)[0],
                None if allowed == "everything" else tuple(_NAME.findall(allowed)),
                tuple(_NAME.findall(never)),
            )
        )
    return found


def contracts() -> str:
    """The contracts as they stand in pyproject.toml."""
    table = rows()
    text: list[str] = []
    for row in table:
        if row.allowed is not None:
            forbidden = [
                other.package for other in table if other.package not in {row.package, *row.allowed}
            ]
            name = f"{row.package} imports {' and '.join(row.allowed) or 'nothing'} of the house"
            text.append(_contract(name, row.package, forbidden, direct=True))
        if row.never:
            name = f"{row.package} never reaches {' or '.join(row.never)}"
            text.append(_contract(name, row.package, row.never, direct=False))
    return "\n".join(text)


def _contract(
    name: str, source: str, forbidden: list[str] | tuple[str, ...], *, direct: bool
) -> str:
    lines = ["[[tool.importlinter.contracts]]", f'name = "{name}"', 'type = "forbidden"']
    lines += [f'source_modules = ["{source}"]', "forbidden_modules = ["]
    lines += [f'    "{module}",' for module in forbidden]
    lines += ["]"]
    if direct:
        lines.append("allow_indirect_imports = true")
    return "\n".join(lines) + "\n"


def project(text: str) -> str:
    """pyproject.toml with the contracts of the table."""
    before, rest = text.split(BEGIN, 1)
    return f"{before}{BEGIN}\n{contracts()}{END}{rest.split(END, 1)[1]}"


if __name__ == "__main__":
    PROJECT.write_text(project(PROJECT.read_text(encoding="utf-8")), encoding="utf-8")
