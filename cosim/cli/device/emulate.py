"""``cohaptic device emulate``: a device that is none, in a process that speaks its real bytes."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.effect import refuse_without
from cosim.cli.support.values import OutputFile

PRESETS = {0: "quanser", 1: "haply"}
"""The pantograph FMU's enumeration of devices."""
_REFERENCES = {"cobs": "cohaptic_device", "force_sensor": "cohaptic_sensor"}
"""Drivers whose device side is in ``hil/firmware``, with its name there."""

if TYPE_CHECKING:
    from contextlib import ExitStack


@click.command("emulate", cls=JsonCommand)
@click.argument("name")
@click.option("--scenario", help="Take pantograph and operator from this scenario ...")
@click.option("--with", "overlays", multiple=True, metavar="FILE", help="... with this over it ...")
@click.option("--component", help="... namely this component and the operator that moves it.")
@click.option(
    "--mechanics",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    metavar="FILE",
    help="What it is made of: mass, friction, gains, who holds it.",
)
@click.option(
    "--firmware",
    is_flag=True,
    help="cobs, force_sensor: compile hil/firmware, and let that answer.",
)
@click.option("--lockstep", is_flag=True, help="Advance only as the driver exchanges.")
@click.option("--link", default="pty", show_default=True, help="pty, slcan or udp_multicast.")
@click.option("--file", "output", type=OutputFile(), help="Write its device file.")
@click.option("--fault", help="A fault to have, such as drop, hang, unplug, runaway.")
@click.option(
    "--after",
    type=click.IntRange(0, 2**31),
    help="Ticks until the fault begins.  [default: 0]",
)
def emulate_device(
    name: str,
    *,
    scenario: str | None,
    overlays: tuple[str, ...],
    component: str | None,
    mechanics: Path | None,
    link: str,
    output: Path | None,
    fault: str | None,
    after: int | None,
    firmware: bool,
    lockstep: bool,
) -> None:
    """Emulate the device NAME in a process that speaks its real bytes, until Ctrl-C.

    Prints one JSON object with the URL that a scenario or ``device check`` takes.
    """
    from contextlib import ExitStack

    from hil.emulation.launch import Emulator, Order
    from hil.emulation.mechanics import Mechanics, load
    from hil.setup.registry import find

    if scenario is None:
        refuse_without(
            "--scenario", {"--with": overlays, "--component": component}, "there is nothing to take"
        )
    if fault is None:
        refuse_without("--fault", {"--after": after}, "nothing begins then")
    preset, pantograph, operator = _emulated(name, scenario, overlays, component)
    with ExitStack() as stack:
        order = Order(
            name=name,
            lockstep=lockstep,
            parameters=pantograph,
            operator=operator,
            mechanics=Mechanics() if mechanics is None else load(mechanics),
            link=link,
            options={"firmware": _firmware(name, stack)} if firmware else {},
            priority=0 if lockstep else 60,
        )
        emulator = stack.enter_context(Emulator(order))
        if fault is not None:
            emulator.control.ask("fault", kind=fault, start=after or 0)
        if output is not None:
            written = {"preset": preset, "home": list(emulator.home)}
            _write_emulated_file(output, name, {} if find(name).measures_only else written)
        click.echo(json.dumps({"url": emulator.url, "home": emulator.home}))
        sys.stdout.flush()
        try:
            emulator.wait()
        except KeyboardInterrupt:
            click.echo("stopped", err=True)


def _firmware(name: str, stack: ExitStack) -> str:
    """The C reference of the device side, compiled for as long as ``stack`` is open.

    Raises:
        InputError: it is another device's, or there is no compiler.
    """
    from importlib.util import find_spec
    from tempfile import TemporaryDirectory

    from cosim.base.errors import InputError
    from hil.firmware.build import build

    if name not in _REFERENCES:
        known = " and ".join(f"'{each}'" for each in _REFERENCES)
        raise InputError(f"--firmware is for {known}, whose device side is ours, not for '{name}'")
    if find_spec("ziglang") is None:
        raise InputError("--firmware needs a compiler: install the package 'ziglang'")
    folder = stack.enter_context(TemporaryDirectory(prefix="cohaptic-firmware-"))
    return str(build(Path(folder), _REFERENCES[name]))


def _write_emulated_file(output: Path, name: str, more: Mapping[str, Any]) -> None:
    from hil.setup.device_edit import save

    save(output, {"driver": name, **more})


def _emulated(
    name: str, scenario: str | None, overlays: tuple[str, ...], component: str | None
) -> tuple[str, Mapping[str, Any], Mapping[str, Any] | None]:
    """Preset and parameters of the pantograph, and parameters of the operator who moves it."""
    from cosim.base.errors import InputError
    from cosim.reading import load
    from hil.setup.registry import find, find_preset

    if scenario is None:
        kind = find(name)
        preset = "quanser" if kind.measures_only else kind.preset
        return preset, find_preset(preset, kind).parameters, None
    loaded = load(scenario, overlays)
    if component is None:
        found = [name for name, each in loaded.components.items() if each.source == "pantograph"]
        raise InputError(
            f"--scenario {scenario}: say which of its components the device is, with "
            f"--component {found[0] if found else 'NAME'}."
        )
    if component not in loaded.components:
        raise InputError(f"{scenario} has no component '{component}'")
    movers = [
        connection.source.component
        for connection in loaded.connections
        if connection.target.component == component and connection.target.path == "hand_force"
    ]
    operator = loaded.components[movers[0]].parameters if movers else None
    # What stands for the wire in a simulation is brought by the wire itself here.
    written = loaded.components[component].parameters
    chosen = written.get("device", 0)
    preset = PRESETS[chosen] if isinstance(chosen, int) and chosen in PRESETS else str(chosen)
    kept = {k: v for k, v in written.items() if k != "computation_delay_ticks"}
    return preset, kept, operator
