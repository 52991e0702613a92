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

if TYPE_CHECKING:
    from contextlib import ExitStack


@click.command("emulate", cls=JsonCommand)
@click.argument("name")
@click.option("--scenario", help="Take pantograph and operator from this scenario ...")
@click.option("--with", "overlays", multiple=True, metavar="FILE", help="... with this over it ...")
@click.option("--component", help="... namely this component and the operator that moves it.")
@click.option("--firmware", is_flag=True, help="cobs: compile and run hil/firmware on its side.")
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

    if scenario is None:
        refuse_without(
            "--scenario", {"--with": overlays, "--component": component}, "there is nothing to take"
        )
    if fault is None:
        refuse_without("--fault", {"--after": after}, "nothing begins then")
    pantograph, operator = _from_scenario(scenario, overlays, component)
    with ExitStack() as stack:
        order = Order(
            name=name,
            lockstep=lockstep,
            parameters=pantograph,
            operator=operator,
            link=link,
            options={"firmware": _firmware(name, stack)} if firmware else {},
            priority=0 if lockstep else 60,
        )
        emulator = stack.enter_context(Emulator(order))
        if fault is not None:
            emulator.control.ask("fault", kind=fault, start=after or 0)
        if output is not None:
            _write_emulated_file(output, name, pantograph, emulator.home)
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

    if name != "cobs":
        raise InputError(f"--firmware is for 'cobs', whose device side is ours, not for '{name}'")
    if find_spec("ziglang") is None:
        raise InputError("--firmware needs a compiler: install the package 'ziglang'")
    folder = stack.enter_context(TemporaryDirectory(prefix="cohaptic-firmware-"))
    return str(build(Path(folder)))


def _write_emulated_file(
    output: Path, name: str, pantograph: Mapping[str, Any], home: tuple[float, float]
) -> None:
    from hil.setup.device_file import save

    preset = "haply" if pantograph.get("device") in {"haply", 1} else "quanser"
    save(output, {"driver": name, "preset": preset, "home": list(home)})


def _from_scenario(
    scenario: str | None, overlays: tuple[str, ...], component: str | None
) -> tuple[Mapping[str, Any], Mapping[str, Any] | None]:
    from cosim.base.errors import InputError
    from cosim.reading import load

    if scenario is None:
        return {"initial_tip_position": (0.0425, 0.2)}, None
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
    return {k: v for k, v in written.items() if k != "computation_delay_ticks"}, operator
