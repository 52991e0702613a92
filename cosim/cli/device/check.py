"""``cohaptic device check``: a safe look at a device; with consent, the proof of its watchdog."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cosim.cli.device.options import FILE, JSON
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.effect import refuse_without
from cosim.cli.support.values import seconds

if TYPE_CHECKING:
    from hil.setup.session import Session


@click.command("check", cls=JsonCommand)
@click.argument("url")
@FILE
@click.option("--seconds", type=seconds(), default=5.0, show_default=True, help="How long to look.")
@click.option(
    "--enable-output",
    is_flag=True,
    help="Also let the device's watchdog fire, at zero torque, and note it in the device file.",
)
@click.option("--yes", is_flag=True, help="Confirm for an emulator that proves to be one.")
@JSON
def check_device(
    url: str,
    file: Path | None,
    seconds: float,
    *,
    enable_output: bool,
    yes: bool,
    as_json: bool,
) -> None:
    """Read the device at URL while you move the handle; it is sent nothing but zero torque.

    With --enable-output its watchdog is proved as well: the output stage is switched on at zero
    torque, then nothing is sent until the device reports that its watchdog has fired. A device
    whose watchdog was never seen to fire is refused force. A force sensor is shown while you push
    on it; it is sent questions alone.
    """
    from dataclasses import asdict

    from cosim.base.errors import InputError
    from cosim.cli.device.sensor import (
        is_sensor,
        look_at_sensor,
        refuse_for_sensor,
        sentences,
    )
    from cosim.cli.support.devices import open_device
    from hil.device.warnings import warnings_of
    from hil.setup.device_edit import add_watchdog_proof
    from hil.setup.look import check
    from hil.setup.watchdog_proof import prove_watchdog

    if is_sensor(url):
        refuse_for_sensor(enable_output=enable_output, yes=yes)
        found = look_at_sensor(url, file, seconds, quiet=as_json)
        click.echo(json.dumps(asdict(found)) if as_json else sentences(found))
        if found.fault is not None:
            click.echo(found.fault, err=True)
            sys.exit(1)
        return
    if not enable_output:
        refuse_without("--enable-output", {"--yes": yes}, "there is nothing to confirm")
    if enable_output and file is None:
        raise InputError("--enable-output notes the proof in the device file: give --file FILE")
    with open_device(url, file) as device:
        for warning in warnings_of(device):
            click.echo(warning, err=True)
        click.echo(f"Move the handle of {device.name}; it gets zero torque.", err=True)
        seen = check(device, seconds, None if as_json else _show)
        proof = None
        if enable_output and seen.fault is None and file is not None:
            device.permission = _session(yes=yes).permission(device)
            proof = prove_watchdog(device)
            add_watchdog_proof(file, proof)
    if as_json:
        proved = None if proof is None else asdict(proof)
        click.echo(json.dumps({**asdict(seen), "watchdog_proof": proved}))
    else:
        click.echo(
            f"\n{seen.samples} samples in {seen.exchanges} exchanges, {seen.rate:.0f} a second, "
            f"oldest data {seen.oldest_sample} ticks; one exchange takes "
            f"{seen.median * 1e6:.0f} µs (median), {seen.p99 * 1e6:.0f} (p99), "
            f"{seen.worst * 1e6:.0f} (worst)\n"
            f"joint 1 from {seen.lowest[0]:.4f} to {seen.highest[0]:.4f} rad, "
            f"joint 2 from {seen.lowest[1]:.4f} to {seen.highest[1]:.4f} rad"
        )
        if proof is not None:
            click.echo(
                f"its watchdog of {proof.timeout * 1e3:.0f} ms was reported to have fired after "
                f"{proof.fired_after * 1e3:.0f} ms of silence; noted in {file}"
            )
    if seen.fault is not None:
        click.echo(seen.fault, err=True)
        sys.exit(1)


def _session(*, yes: bool) -> Session:
    """Output was asked for; a person at a terminal is asked back."""
    from cosim.cli.support.devices import ask_person
    from hil.setup.session import Session

    return Session(enable_output=True, yes=yes, prompt=ask_person if sys.stdin.isatty() else None)


def _show(angle: tuple[float, float], age: int) -> None:
    click.echo(f"\r{angle[0]:9.4f} {angle[1]:9.4f} rad   age {age} ticks ", err=True, nl=False)
