"""``cohaptic ssp``: systems of SSP and OSP as scenarios, and scenarios as SSP."""

from __future__ import annotations

from pathlib import Path

import click

from cosim.base.errors import InputError, RunError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.complete import scenario_names
from cosim.cli.support.values import OutputFile


@click.group("ssp")
def command() -> None:
    """Read systems of SSP and OSP, and write scenarios as SSP."""


@command.command("import", cls=JsonCommand)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--out", type=OutputFile(), required=True, help="The scenario; a new file.")
@click.option("--stop-time", metavar="TIME", help="How long to run, where the system does not say.")
def import_command(*, file: Path, out: Path, stop_time: str | None) -> None:
    """Write the scenario that FILE describes: an .ssp, an .ssd, or an OspSystemStructure.xml.

    Its FMUs stay where they are; those of an .ssp are in the cache.
    """
    from cosim.base.document.yaml_writer import write_yaml
    from cosim.cli.ssp.system import document_of

    if out.exists():
        raise InputError(f"{out} is there.")
    document, notes = document_of(str(file), stop_time)
    for note in notes:
        click.echo(f"note: {note}", err=True)
    try:
        out.write_text(write_yaml(document), encoding="utf-8")
    except OSError as error:
        raise RunError(f"{out} cannot be written: {error.strerror}.") from None
    click.echo(str(out))


@command.command("export", cls=JsonCommand)
@click.argument("scenario", shell_complete=scenario_names)
@click.option("--with", "overlays", multiple=True, metavar="FILE", help="As of cohaptic run.")
@click.option("--set", "sets", multiple=True, metavar="A.B=C", help="As of cohaptic run.")
@click.option("--out", type=OutputFile(), required=True, help="The package; a new file.")
def export_command(
    *, scenario: str, overlays: tuple[str, ...], sets: tuple[str, ...], out: Path
) -> None:
    """Write SCENARIO with all of its FMUs as a package of SSP 2.0."""
    from cosim.master.run.simulation import assemble
    from cosim.reading import load
    from cosim.ssp.exporting import to_ssp

    if out.exists():
        raise InputError(f"{out} is there.")
    with assemble(load(scenario, overlays, sets)) as simulation:
        content = to_ssp(simulation.assembly)
    try:
        out.write_bytes(content)
    except OSError as error:
        raise RunError(f"{out} cannot be written: {error.strerror}.") from None
    click.echo(str(out))
