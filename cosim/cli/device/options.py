"""What several device commands take."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.option(
    "--file", type=click.Path(path_type=Path), help="The device file. [default: the maker's values]"
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
