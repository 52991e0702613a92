"""``cohaptic identify``: inertia, friction, latency, offset and gain of a device, from its runs."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import click

from cosim.base.errors import InputError
from cosim.base.system.writing import writing
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.effect import given_of, refuse_without
from cosim.cli.support.terminal.complete import run_folders
from cosim.cli.support.values import FIGURES, Number, OutputFile, Quantity

LONGEST = 600.0


@click.command("identify", cls=JsonCommand)
@click.argument("runs", nargs=-1, type=click.Path(path_type=Path), shell_complete=run_folders)
@click.option(
    "--plan",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    metavar="DEVICE.yaml",
    help="Instead: write the scenario of an excitation for this device into --out.",
)
@click.option("--url", help="With --plan: where the device is, such as haply:///dev/ttyACM0.")
@click.option(
    "--seconds",
    type=Number(10, LONGEST),
    help="With --plan: how long it excites.  [default: 60]",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 1),
    help="With --plan: of the sines' phases.  [default: 1]",
)
@click.option(
    "--payload",
    "payloads",
    multiple=True,
    metavar="[RUN=]MASS",
    help="A known mass on the tip: of the plan, or of a run that is not a plan's (RUN=50 g).",
)
@click.option("--component", metavar="NAME", help="Which device, where a run has several.")
@click.option(
    "--device",
    "device_file",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    metavar="FILE",
    help="Its device file, where that of the run has moved.",
)
@click.option(
    "--force",
    metavar="SIGNAL",
    help="Recorded force of a sensor on the tip, such as force_a1.force.",
)
@click.option(
    "--sides",
    type=click.Choice(("alike", "apart")),
    help="Whether both sides have the same inertia.  [default: alike]",
)
@click.option(
    "--out",
    type=OutputFile((".yaml", ".yml")),
    help="Write a preset of the pantograph; with --plan the scenario.",
)
@click.option("--figure", type=OutputFile(FIGURES), help="Draw torque, model and residual.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    runs: tuple[Path, ...],
    *,
    plan: Path | None,
    url: str | None,
    seconds: float | None,
    seed: int | None,
    payloads: tuple[str, ...],
    component: str | None,
    device_file: Path | None,
    force: str | None,
    sides: str | None,
    out: Path | None,
    figure: Path | None,
    as_json: bool,
) -> None:
    """Tell what a device is from what it did: the folders RUNS of its runs, or the --plan for one.

    Exit status: 0 it is told, 1 the residual is not white or a length is wrong (the model lacks
    something that these runs hold), 2 the runs cannot be used.
    """
    if plan is not None:
        _refuse_beside_plan(
            {
                "RUNS": runs,
                "--component": component,
                "--device": device_file,
                "--force": force,
                "--sides": sides,
                "--figure": figure,
            }
        )
        said = _plan(
            plan, out, payloads, url=url, seconds=seconds or 60.0, seed=1 if seed is None else seed
        )
        click.echo(json.dumps(said) if as_json else _instruction(said))
        return
    refuse_without(
        "--plan", {"--url": url, "--seconds": seconds, "--seed": seed}, "no plan is written"
    )
    if not runs:
        raise InputError("name one or several run folders, or a device file with --plan.")
    from cohaptic.identified import identify

    found = identify(
        *runs,
        payloads=_loads(payloads, runs),
        component=component,
        device=device_file,
        force=force,
        alike=sides != "apart",
    )
    if out is not None:
        from cosim.identification.preset import preset

        with writing(out):
            out.write_text(preset(found, out.name), encoding="utf-8")
    if figure is not None:
        from cosim.identification.figure import draw

        draw(found, figure)
    from cosim.identification.report import lines, plain

    click.echo(json.dumps(plain(found)) if as_json else "\n".join(lines(found)))
    if not found.is_whole:
        sys.exit(1)


def _refuse_beside_plan(given: dict[str, object]) -> None:
    named = given_of(given)
    if named:
        raise InputError(f"{' and '.join(named)} beside --plan: a plan is made before any run.")


def _loads(payloads: tuple[str, ...], folders: tuple[Path, ...]) -> dict[str, float]:
    """The mass (kg) on the tip of each run that was said."""
    found: dict[str, float] = {}
    for text in payloads:
        name, equals, mass = text.rpartition("=")
        if not equals:
            raise InputError(f"--payload {text}: say of which run, such as {folders[0]}=50g.")
        if name in found:
            raise InputError(f"--payload {text}: the payload of that run was said before.")
        found[name] = _mass(mass)
    return found


def _mass(text: str) -> float:
    from cohaptic.identified import HEAVIEST

    value = float(Quantity("kg").convert(text, None, None))
    if value > HEAVIEST:
        raise InputError(f"--payload {text}: at most {HEAVIEST:g} kg goes on a tip.")
    return value


def _plan(
    path: Path,
    out: Path | None,
    payloads: tuple[str, ...],
    *,
    url: str | None,
    seconds: float,
    seed: int,
) -> dict[str, Any]:
    """Write the scenario of an excitation; what was chosen.

    Raises:
        InputError: the device only measures, has no home pose, or leaves no room to move.
    """
    from cohaptic.described import envelope, model_of
    from cosim.identification.excitation.plan import plan
    from cosim.identification.nominal import Nominal
    from hil.setup.address import parse
    from hil.setup.device_file import load

    if url is None:
        raise InputError("--plan needs --url: where the device is, such as haply:///dev/ttyACM0.")
    if out is None:
        raise InputError("--plan needs --out: the scenario to write, such as excitation.yaml.")
    if len(payloads) > 1 or any("=" in each for each in payloads):
        raise InputError("--payload of a plan is one mass, such as --payload 50g.")
    file = load(path)
    if parse(url).driver != file.driver:
        raise InputError(f"{path} is a device file for '{file.driver}', not for {url}.")
    if file.home is None:
        raise InputError(
            f"{path} has no 'home' pose, so nobody knows where the handle starts: write one with "
            "'cohaptic device calibrate'."
        )
    payload = _mass(payloads[0]) if payloads else 0.0
    limits = envelope(file)
    made = plan(
        url=url,
        file=str(path.resolve()),
        envelope=limits,
        values=Nominal.of(model_of(file.preset)).values(limits.bar, payload),
        home=file.home,
        seconds=seconds,
        payload=payload,
        seed=seed,
    )
    with writing(out):
        out.write_text(made.text(), encoding="utf-8")
    return {
        "ok": True,
        "scenario": str(out),
        "duration": made.duration,
        "payload": payload,
        "slow": made.trajectory.slow,
        "fast": made.trajectory.fast,
        "use": made.use(file.home),
    }


def _instruction(said: dict[str, Any]) -> str:
    from cosim.identification.excitation.envelope import SHARE

    use = ", ".join(f"{name} {share:.0%}" for name, share in said["use"].items())
    loaded = f" Put {said['payload'] * 1e3:g} g on the tip." if said["payload"] else ""
    scenario = said["scenario"]
    return (
        f"{scenario} is written: {said['duration']} s; of what it may use of the limits "
        f"({SHARE:.0%} of most): {use}.\n"
        f"Hold the handle at its home pose for homing, then let go of it: the motors move it alone."
        f"{loaded}\n"
        f"  cohaptic run {scenario} --realtime --enable-output --out RUN\n"
        f"  cohaptic identify RUN"
    )
