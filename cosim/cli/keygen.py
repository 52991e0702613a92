"""``cohaptic keygen FILE``: a new pre-shared key for a link."""

from __future__ import annotations

import json
from pathlib import Path

import click

from cosim.cli.support.command import JsonCommand


@click.command("keygen", cls=JsonCommand)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(file: Path, *, as_json: bool) -> None:
    """Write a new random key to FILE, readable by its owner alone.

    Copy the file to every station of the session by a safe way (scp, a memory stick); whoever
    holds it can push on a user's hand.
    """
    from cosim.link.session.keys import create_key_file

    create_key_file(file)
    if as_json:
        click.echo(json.dumps({"key_file": str(file)}))
    else:
        click.echo(f"{file} holds a new key; copy it to the other stations by a safe way.")
