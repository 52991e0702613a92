"""``cohaptic theory table``: the tables of chapter 6, the thesis's numbers beside ours."""

from __future__ import annotations

import json
from typing import Any

import click

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.cli.support.command import JsonCommand
from cosim.theory.chapters.chapter_6 import table_6_1, table_6_2


@click.command(cls=JsonCommand)
@click.argument("number", metavar="NUMBER")
@click.option(
    "--ratio",
    type=click.IntRange(1, 1000),
    default=8,
    show_default=True,
    help="N, for 6.2.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(number: str, ratio: int, as_json: bool) -> None:
    """Print Table 6.1 (parameters) or 6.2 (damping of the original and simplified models)."""
    tables = {"6.1": table_6_1, "6.2": lambda: table_6_2(ratio)}
    if number not in tables:
        raise InputError(f"There is no table {number!r}.{did_you_mean(number, tables)}")
    rows: list[dict[str, Any]] = tables[number]()
    if as_json:
        click.echo(json.dumps({"table": number, "rows": rows}, ensure_ascii=False))
        return
    for row in rows:
        if number == "6.1":
            click.echo(
                f"{row['architecture']:<12} {row['parameter']:<5} {row['value']:g} {row['unit']}"
            )
        else:
            click.echo(
                f"{row['architecture']:<12} {row['model']:<11} {row['damping']:.4g} N·s/m"
                f"   (thesis {row['thesis']})"
            )
