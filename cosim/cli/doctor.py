"""``cohaptic doctor``: whether this machine can run devices, and what to do where it cannot."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import seconds

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hil.setup.doctor.note import DoctorNote

COLOURS = {"good": "green", "poor": "yellow", "bad": "red"}
VERDICTS = {
    "good": "This machine can run devices.",
    "poor": "This machine can run devices; what is poor above makes them worse than they could be.",
    "bad": "This machine is not fit for devices with force until what is bad above is put right.",
}


@click.command("doctor", cls=JsonCommand)
@click.option(
    "--seconds",
    type=seconds(),
    default=10.0,
    show_default=True,
    help="How long a loop without a device is measured.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(seconds: float, *, as_json: bool) -> None:
    """Look at kernel, priorities, memory, processors, ports, CAN and a loop's lateness.

    Each is good, poor or bad, with a sentence that says what to do. Exit status 1: one is bad.
    """
    from dataclasses import asdict

    found: list[DoctorNote] = []
    for note in _notes(seconds):
        found.append(note)
        if not as_json:
            mark = click.style(f"{note.health:6}", fg=COLOURS[note.health])
            click.echo(f"{mark}{note.name:15}{note.sentence}")
    verdict = max((note.health for note in found), key=list(VERDICTS).index)
    if as_json:
        notes = [asdict(note) for note in found]
        click.echo(json.dumps({"notes": notes, "verdict": verdict}))
    else:
        click.echo(VERDICTS[verdict])
    sys.exit(verdict == "bad")


def _notes(seconds: float) -> Iterator[DoctorNote]:
    from hil.setup.doctor.can import can_notes
    from hil.setup.doctor.lateness import lateness_note, lateness_of_a_process
    from hil.setup.doctor.machine import machine_notes
    from hil.setup.doctor.note import good, poor
    from hil.setup.doctor.ports import port_notes

    yield from machine_notes()
    yield from port_notes()
    yield from can_notes()
    freed = _left_in_memory()
    if freed:
        yield poor("leftovers", f"killed runs had left {freed / 1e6:.1f} MB in memory: removed")
    else:
        yield good("leftovers", "no killed run has left anything in memory")
    click.echo(f"A loop without a device is measured for {seconds:g} s ...", err=True)
    yield lateness_note(lateness_of_a_process(seconds))


def _left_in_memory() -> int:
    from cosim.base.system.room import shared_folder
    from cosim.realtime.shared.leftovers import remove_leftovers

    return remove_leftovers(shared_folder())
