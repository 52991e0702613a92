"""Every number and every place that a command takes is judged before anything is done with it.

The options are click's own: one that is new, and neither limited nor named here, fails.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from cosim.base.errors import CohapticError, InputError
from cosim.cli import cli
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number, OutputFile, OutputFolder

Found = tuple[str, click.Command, click.Parameter]

READ = {
    *("device check --file", "device home --file", "device calibrate --file", "keygen FILE"),
    *("device conform --file", "device emulate --mechanics"),
    *("identify RUNS", "identify --plan", "identify --device"),
    *("merge RUNS", "record compact RUN", "record compress RUNS", "record digest RUNS"),
    *("record export RUN", "record list RUN", "record summary RUN", "render RUN"),
    "ssp import FILE",
    *("study run PLAN", "study table PLAN", "study exclude PLAN"),
    "study include PLAN",
    *("compare ONE", "compare OTHER", "replay RUN", "runs FOLDER", "intent RUNS"),
}
"""Paths that are read, or created by what refuses them itself (a key)."""
LOOP = ("--architecture", "distributed")
THEORY = {
    "admittance": ("--frequency", "3"),
    "boundary": ("--vary", "k_11", "--range", "1:2"),
    "map": ("--vary", "k_11", "--range", "1:2", "--vary", "k_12", "--range", "1:2"),
    "passivity": ("--device-damping", "0.1"),
}
JUDGED_BY_THE_MODEL = {
    *("--round-trip-delay", "--each-way-delay", "--forward-delay", "--backward-delay"),
    *("--computation-delay", "--users"),
}
"""Of the theory's loop: its sentences say more than a range."""
BAD_WHOLE = ("-1", "1.5", "nan", "inf", "10000000000000000000000", "many")
BAD_NUMBER = ("-1e300", "1e300", "nan", "inf", "-inf", "many")


def commands(group: click.Group, path: str = "") -> Iterator[tuple[str, click.Command]]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        if isinstance(command, click.Group):
            yield from commands(command, f"{path}{name} ")
        else:
            yield f"{path}{name}", command


EVERY = dict(commands(cli))
PARAMETERS: list[Found] = [(p, c, option) for p, c in EVERY.items() for option in c.params]
NUMERIC = click.types.IntParamType | click.types.FloatParamType
NUMBERS = [f for f in PARAMETERS if isinstance(f[2].type, NUMERIC)]
PATHS = [f for f in PARAMETERS if isinstance(f[2].type, click.Path)]


def label(found: Found) -> str:
    path, _, option = found
    written = option.opts[0] if isinstance(option, click.Option) else option.opts[0].upper()
    return f"{path} {written}"


def refused(arguments: list[str]) -> str:
    """The sentence of a refusal with status 2."""
    done = CliRunner().invoke(cli, arguments, standalone_mode=False)
    error = done.exception
    assert isinstance(error, click.UsageError | InputError), (arguments, error, done.output)
    return error.format_message() if isinstance(error, click.UsageError) else str(error)


@pytest.mark.parametrize("found", NUMBERS, ids=label)
def test_a_number_has_two_ends(found: Found) -> None:
    _, _, option = found
    kind = option.type
    if option.opts[0] in JUDGED_BY_THE_MODEL:
        return
    assert isinstance(kind, Number | click.IntRange) or option.opts[0] == "--size", label(found)
    if isinstance(kind, Number | click.IntRange):
        assert kind.min is not None
        assert kind.max is not None


@pytest.mark.parametrize("found", NUMBERS, ids=label)
def test_a_number_out_of_range_is_refused(found: Found, tmp_path: Path) -> None:
    path, command, option = found
    whole = isinstance(option.type, click.types.IntParamType)
    for bad in BAD_WHOLE if whole else BAD_NUMBER:
        given = [*path.split(), *arguments_of(path, command, option, tmp_path)]
        values = [bad] * max(1, option.nargs)
        assert refused([*given, option.opts[0], *values])


def arguments_of(
    path: str, command: click.Command, without: click.Parameter, folder: Path
) -> list[str]:
    """What the command needs besides the option."""
    if path.startswith("theory ") and any(o.opts[0] == "--architecture" for o in command.params):
        extra = THEORY.get(path.split()[1], ())
        return [*LOOP, *(() if without.opts[0] in extra else extra)]
    needed: list[str] = []
    for each in command.params:
        if each is without or not each.required:
            continue
        value = {"--home": ["2.4", "0.7"], "--as": ["a"]}.get(each.opts[0])
        place = [str(folder / "x.png")]
        if isinstance(each, click.Argument):
            needed += place if isinstance(each.type, click.Path) else ["127.0.0.1:1"]
        else:
            needed += [each.opts[0], *(value or place)]
    return needed


@pytest.mark.parametrize("found", PATHS, ids=label)
def test_a_place_is_judged(found: Found, tmp_path: Path) -> None:
    path, command, option = found
    kind = option.type
    if label(found) in READ or label(found).endswith("--key"):
        return
    assert isinstance(kind, OutputFile | OutputFolder), label(found)
    file = tmp_path / "file"
    file.write_text("x")
    inside = file / "below.png"
    bad = [inside] if isinstance(kind, OutputFolder) else [inside, tmp_path / "no" / "where.png"]
    bad += [file] if isinstance(kind, OutputFolder) else [tmp_path]
    for place in bad:
        given = arguments_of(path, command, option, tmp_path)
        own = [str(place)] if isinstance(option, click.Argument) else [option.opts[0], str(place)]
        order = [*given, *own] if given or isinstance(option, click.Option) else own
        assert str(place.parent) in refused([*path.split(), *order]) or place == tmp_path


@pytest.mark.parametrize("path", EVERY)
def test_bad_input_is_one_object_with_json(path: str) -> None:
    command = EVERY[path]
    assert isinstance(command, JsonCommand)
    if all(option.name != "as_json" for option in command.params):
        return
    done = CliRunner().invoke(cli, [*path.split(), "--json", "--no-such-option"])
    answer = json.loads(done.stdout)
    assert done.exit_code == 2
    assert answer["ok"] is False
    assert "no-such-option" in answer["problems"][0]["message"]


@pytest.mark.parametrize("command", ["loss", "radius", "margins", "damping", "design"])
@pytest.mark.parametrize("delay", ["100000", "501"])
def test_a_delay_that_fills_the_memory_is_refused_with_the_limit(command: str, delay: str) -> None:
    said = refused(["theory", command, *LOOP, "--each-way-delay", delay])
    assert f"{delay} network samples; the theory goes up to 500 one way" in said


def test_second_moments_that_fill_the_memory_are_refused_with_the_limit() -> None:
    said = refused(["theory", "loss", *LOOP, "--each-way-delay", "100"])
    assert "up to 1 GB are allowed" in said


def test_an_emulator_is_told_by_its_nearest_name() -> None:
    assert "haply" in refused(["device", "emulate", "hapl"])


def test_a_link_that_an_emulator_does_not_have_is_refused() -> None:
    done = CliRunner().invoke(
        cli, ["device", "emulate", "haply", "--link", "bogus"], standalone_mode=False
    )
    assert isinstance(done.exception, CohapticError)
