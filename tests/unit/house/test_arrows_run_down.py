"""No modules import each other in a circle, and the table of ARCHITECTURE.md is what is checked."""

from __future__ import annotations

from tests.support.house.contracts import PROJECT, project, rows
from tests.support.house.imports import circles, graph, sources


def _package(module: str) -> str:
    """The row of the table that a module belongs to."""
    parts = module.split(".")
    return ".".join(parts[:2]) if parts[0] == "cosim" else parts[0]


def test_no_modules_import_each_other_in_a_circle() -> None:
    assert circles(graph(sources())) == []


def test_a_circle_would_be_found() -> None:
    ring = {"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}, "e": set[str]()}
    assert circles(ring) == [["a", "b", "c"]]


def test_the_table_covers_every_package() -> None:
    there = {_package(module) for module in sources()} - {"cosim"}
    assert {row.package for row in rows()} == there
    assert len(rows()) == len(there)


def test_a_row_names_only_rows_below_it() -> None:
    order = [row.package for row in rows()]
    for position, row in enumerate(rows()):
        assert set(row.allowed or ()) <= set(order[position + 1 :]), row.package


def test_every_import_is_in_the_table_and_nothing_else_is() -> None:
    used = {row.package: set[str]() for row in rows()}
    for module, others in graph(sources()).items():
        if module != "cosim":
            used[_package(module)] |= {_package(other) for other in others} - {_package(module)}
    for row in rows():
        if row.allowed is not None:
            assert used[row.package] == set(row.allowed), row.package


def test_the_contracts_are_those_of_the_table() -> None:
    text = PROJECT.read_text(encoding="utf-8")
    assert project(text) == text, "write them anew: python -m tests.support.house.contracts"
