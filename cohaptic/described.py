"""A device's geometry, limits and declared latency, from its file or the model's parameters."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import quantity
from cosim.scenario import Kind, Scenario

if TYPE_CHECKING:
    from cosim.identification.excitation.envelope import Envelope
    from cosim.identification.samples import Described
    from cosim.scenario import ScenarioComponent
    from hil.setup.device_file import DeviceFile


def described(scenario: Scenario, component: str, file: Path | None) -> Described:
    """What is known of a component's device; ``file`` wins over the one that the run names.

    Raises:
        InputError: it is no device and no pantograph, or its file cannot be read.
    """
    part = scenario.components[component]
    if part.kind is Kind.DEVICE:
        return _device(part, file)
    if part.kind is Kind.FMU and part.source == "pantograph":
        if file is not None:
            raise InputError(f"--device has no effect: '{component}' is simulated in this run.")
        return _pantograph(part)
    raise InputError(
        f"'{component}' is a component of kind {part.kind}: only a device or a simulated "
        "pantograph has a geometry to go by."
    )


def envelope(file: DeviceFile) -> Envelope:
    """The limits that an excitation of a device has to keep."""
    from cosim.identification.excitation.envelope import Envelope
    from cosim.identification.five_bar import FiveBar

    limits, region = file.limits, file.region or file.linkage.default_region()
    return Envelope(
        bar=FiveBar(**asdict(file.linkage)),
        torque=limits.torque,
        continuous_torque=limits.continuous_torque,
        slew=limits.slew,
        tip_speed=limits.tip_speed,
        joint_speed=limits.joint_speed,
        dexterity=limits.dexterity,
        region=(region.left, region.right, region.bottom, region.top),
    )


def model_of(preset: str) -> str:
    """The published device whose dynamics stand for a preset; of one's own, the Quanser-like."""
    return preset if preset in {"quanser", "haply"} else "quanser"


def _device(part: ScenarioComponent, file: Path | None) -> Described:
    from cosim.identification.five_bar import FiveBar
    from cosim.identification.samples import Described
    from hil.device.board.component import address_of
    from hil.device.component import device_file
    from hil.device.driver import Driver
    from hil.setup.registry import find

    address = address_of(part.source, part.options)
    kind = find(address.driver)
    if kind.measures_only:
        raise InputError(f"'{part.name}' only measures: nothing pushes there.")
    options: dict[str, Any] = dict(part.options)
    if file is not None:
        options = {"file": str(file)}
    read = device_file(cast("type[Driver]", kind), options)
    return Described(
        bar=FiveBar(**asdict(read.linkage)),
        preset=model_of(read.preset),
        limit=read.limits.torque,
        latency_ticks=kind.latency_of(address),
        home=read.home,
    )


def _pantograph(part: ScenarioComponent) -> Described:
    from cosim.identification.five_bar import FiveBar
    from cosim.identification.samples import Described
    from fmus.shared.mechanism.device import DEVICE, presets

    given = part.parameters
    chosen = given.get("device", 0)
    names = {item.value: item.name for item in DEVICE.items}
    name = names.get(chosen, "custom") if isinstance(chosen, int) else str(chosen)
    at = 1 if name == "haply" else 0
    known = {**presets("GEOMETRY"), "torque_limit": presets("DYNAMICS")["torque_limit"]}

    def value(parameter: str, unit: str = "m") -> float:
        own = given.get(parameter, -1.0)
        assert isinstance(own, (int, float, str)), "one value"
        found = float(quantity(own, unit))
        return known[parameter][at] if found == -1 else found

    delay = given.get("computation_delay_ticks", 0)
    return Described(
        bar=FiveBar(
            proximal=value("proximal_length"),
            distal=value("distal_length"),
            base=value("base_distance"),
        ),
        preset=model_of(name),
        limit=value("torque_limit", "N.m"),
        latency_ticks=int(delay) if isinstance(delay, (int, float)) else 0,
    )
