"""``cohaptic fmu``: the FMUs that come with cohaptic, and a look into any FMU."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import click

from cosim.base.errors import InputError, RunError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import OutputFolder

_FLAVOURS = click.Choice(["fmi2", "fmi3", "fmi3-arrays", "all"])


@click.group("fmu")
def command() -> None:
    """List, inspect, export and build FMUs."""


@command.command("list", cls=JsonCommand)
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def list_command(*, as_json: bool) -> None:
    """The models that come with cohaptic."""
    from fmus import model_names
    from fmus.builder import load_model
    from fmus.layout import SlotLayout

    models: list[dict[str, Any]] = []
    for name in model_names():
        model = load_model(name)
        layout = SlotLayout(model)
        count = {
            causality: sum(e.variable.causality == causality for e in layout.elements)
            for causality in ("input", "output", "parameter")
        }
        models.append({"name": name, "description": model.description, **count})
    if as_json:
        click.echo(json.dumps({"models": models}, indent=2))
        return
    width = max(len(model["name"]) for model in models)
    for model in models:
        sizes = f"{model['input']} in, {model['output']} out, {model['parameter']} parameters"
        click.echo(f"{model['name']:<{width}}  {model['description']} ({sizes})")


@command.command("inspect", cls=JsonCommand)
@click.argument("file")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def inspect_command(*, file: str, as_json: bool) -> None:
    """What FILE, an FMU or one of ours by name, offers: variables, clocks, terminals, platforms."""
    from cosim.cli.support.fmu.report import describe, to_text

    report = describe(_locate(file))
    click.echo(json.dumps(report, indent=2) if as_json else to_text(report))


@command.command("export", cls=JsonCommand)
@click.argument("folder", type=OutputFolder())
@click.argument("names", nargs=-1)
@click.option("--flavour", type=_FLAVOURS, default="all", help="Which archives; all by default.")
@click.option("--force", is_flag=True, help="Replace files that are there.")
def export_command(*, folder: Path, names: tuple[str, ...], flavour: str, force: bool) -> None:
    """Copy our FMUs (all, or those named) into FOLDER, for use in other tools."""
    import shutil

    from fmus import find, model_names
    from fmus.archive import FLAVOURS

    flavours = FLAVOURS if flavour == "all" else (flavour,)
    sources = [find(name, each) for name in names or model_names() for each in flavours]
    there = [source.name for source in sources if (folder / source.name).exists()]
    if there and not force:
        raise InputError(f"{folder / there[0]} is there; give --force to replace what is there.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for source in sources:
            shutil.copyfile(source, folder / source.name)
    except OSError as error:
        raise RunError(f"The FMUs cannot be written to {folder}: {error.strerror}.") from None
    click.echo(f"{len(sources)} FMUs written to {folder}")


@command.command("validate", cls=JsonCommand)
@click.argument("file")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def validate_command(*, file: str, as_json: bool) -> None:
    """Whether FILE, an FMU, keeps the standard's rules and starts on this machine.

    Exit status: 0 nothing was found; 1 a rule is broken or it does not start; 2 it is no FMU.
    """
    from cosim.cli.support.fmu.check import judge

    verdict = judge(_locate(file))
    if as_json:
        click.echo(
            json.dumps(
                {
                    "ok": verdict.is_good,
                    "breaks": list(verdict.breaks),
                    "starts": not verdict.failure,
                    "failure": verdict.failure,
                },
                indent=2,
            )
        )
    else:
        for each in verdict.breaks:
            click.echo(f"modelDescription.xml: {each}")
        click.echo(verdict.failure or f"{file} starts and ends on this machine")
    sys.exit(0 if verdict.is_good else 1)


@command.command("new", cls=JsonCommand)
@click.argument("folder", type=OutputFolder())
def new_command(*, folder: Path) -> None:
    """Write a model that works into FOLDER, to be changed and built."""
    from cosim.cli.support.fmu.new_model import write_new

    for file in write_new(folder):
        click.echo(str(file))


@command.command("build", cls=JsonCommand)
@click.argument("names", nargs=-1, metavar="[MODEL]...")
@click.option("--force", is_flag=True, help="Build also what is up to date.")
@click.option(
    "--out",
    type=OutputFolder(),
    help="Where the FMUs of a folder of yours go. [default: the working folder]",
)
def build_command(*, names: tuple[str, ...], force: bool, out: Path | None) -> None:
    """Compile the model in a folder (see fmu new), or our own, for every platform.

    Our own, all or those named, are built in a checkout where their sources changed.
    """
    from cosim.cli.support.fmu.new_model import source_in
    from fmus import check_name, is_checkout, model_names
    from fmus.builder import build_fmus, source_of
    from fmus.compiler import BuildError

    folders = [name for name in names if Path(name).is_dir() or "/" in name]
    if len(folders) < max(len(names), 1) and not is_checkout():
        raise InputError(
            "Our own FMUs are built in a checkout of cohaptic; here they came with it. Name a "
            "folder with a model of yours (cohaptic fmu new writes one)."
        )
    if out is not None and not folders:
        raise InputError("--out is for a folder with a model of yours.")
    for name in names:
        if name not in folders:
            check_name(name)
    try:
        for name in names or model_names():
            if name in folders:
                built = build_fmus(source_in(Path(name)), output=out or Path.cwd(), force=force)
            else:
                built = build_fmus(source_of(name), force=force)
            click.echo(f"{name}: {'built' if built else 'up to date'}")
    except BuildError as error:
        raise RunError(str(error)) from None


def _locate(file: str) -> Path:
    from fmus import find

    path = Path(file)
    return path if path.exists() or path.suffix == ".fmu" else find(file)
