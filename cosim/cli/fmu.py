"""``cohaptic fmu``: the FMUs that come with cohaptic, and a look into any FMU."""

from __future__ import annotations

import json
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
    """What FILE, an FMU or the name of one of ours, offers: variables, terminals, platforms."""
    from cosim.cli.support.fmu_report import describe, to_text

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


@command.command("build", cls=JsonCommand)
@click.argument("names", nargs=-1)
@click.option("--force", is_flag=True, help="Build also what is up to date.")
def build_command(*, names: tuple[str, ...], force: bool) -> None:
    """Compile our FMUs (all, or those named) for every platform, where sources changed."""
    from fmus import check_name, is_checkout, model_names
    from fmus.builder import build_fmus, source_of
    from fmus.compiler import BuildError

    if not is_checkout():
        raise InputError("FMUs are built in a checkout of cohaptic; here they came with it.")
    for name in names:
        check_name(name)
    try:
        for name in names or model_names():
            built = build_fmus(source_of(name), force=force)
            click.echo(f"{name}: {'built' if built else 'up to date'}")
    except BuildError as error:
        raise RunError(str(error)) from None


def _locate(file: str) -> Path:
    from fmus import find

    path = Path(file)
    return path if path.exists() or path.suffix == ".fmu" else find(file)
