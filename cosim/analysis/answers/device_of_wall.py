"""Which device of a scenario renders a wall, and whether that wall is its workstation's own."""

from __future__ import annotations

import re
from dataclasses import dataclass

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.scenario import Scenario, ScenarioComponent

RENDERING = ("distributed_workstation", "central_server")
"""The models that compute the forces of their own fingers."""
_FINGER = re.compile(r"finger_(?P<number>\d+)")


@dataclass(frozen=True, slots=True)
class ScenarioDevice:
    """A device of a scenario and the workstation that renders its wall.

    Attributes:
        device: the pantograph.
        station: the workstation.
        finger: which of its fingers the device is, counted from 1.
        axis: 0: the wall's normal is along x, 1: along y.
    """

    device: ScenarioComponent
    station: ScenarioComponent
    finger: int
    axis: int


def find_device(scenario: Scenario, name: str | None, axis: int) -> ScenarioDevice:
    """The device of that name, or the first that a workstation renders forces to.

    Raises:
        InputError: there is none, it is no simulated pantograph, or its wires are delayed.
    """
    parts = scenario.components
    found: dict[str, ScenarioDevice] = {}
    for link in scenario.connections:
        source, target = parts.get(link.source.component), parts.get(link.target.component)
        number = _FINGER.match(link.target.path)
        if source is None or target is None or number is None or link.via is not None:
            continue
        found[source.name] = ScenarioDevice(source, target, int(number["number"]), axis)
    if name is None:
        name = next((one for one in found if parts[one].source == "pantograph"), None)
    if name not in found:
        raise InputError(
            "The scenario has no pantograph whose forces a workstation renders."
            if name is None
            else f"--finger {name}: no workstation renders forces to a device of that name."
            f"{did_you_mean(name, found)}"
        )
    one = found[name]
    if not (one.device.is_bundled and one.device.source == "pantograph"):
        raise InputError(
            f"{name} is no simulated pantograph, so that its wall cannot be simulated: put the "
            "pantograph with its preset in its place.",
            scenario.locate(("components", name)),
        )
    _refuse_other_wires(scenario, one)
    _refuse_other_steps(scenario, one)
    return one


def _refuse_other_wires(scenario: Scenario, one: ScenarioDevice) -> None:
    """Refuse forces that come from elsewhere than the wall's, or otherwise than they are computed.

    Raises:
        InputError: by name and place.
    """
    device, station = one.device.name, one.station.name
    if one.station.source not in RENDERING:
        raise InputError(
            f"{station} is told the forces of {device} by another part, so that its wall is no "
            f"workstation's own: ask for the run ('theory radius'), or for a finger of "
            f"{' or '.join(RENDERING)}.",
            scenario.locate(("components", station)),
        )
    wanted = {
        (f"{device}.device", f"{station}.finger_{one.finger}"),
        (f"{station}.finger_{one.finger}", f"{device}.device"),
    }
    found: set[tuple[str, str]] = set()
    for number, link in enumerate(scenario.connections):
        ends = {link.source.component, link.target.component}
        if ends != {device, station}:
            continue
        is_other = link.delay.ticks or link.rate or (link.factor, link.offset) != (1.0, 0.0)
        if is_other or (str(link.source), str(link.target)) not in wanted:
            raise InputError(
                f"{link} is delayed, sampled, scaled or a part of what is rendered, and the wall "
                "here has none of that: connect the two as they are.",
                scenario.locate(("connections", number)),
            )
        found.add((str(link.source), str(link.target)))
    for source, target in sorted(wanted - found):
        raise InputError(
            f"Nothing goes from {source} to {target}, so that {device} does not render a wall of "
            f"{station}.",
            scenario.locate(("connections",)),
        )


def _refuse_other_steps(scenario: Scenario, one: ScenarioDevice) -> None:
    """Refuse a device and a workstation that step otherwise than both once, in the same tick.

    Raises:
        InputError: by name and place.
    """
    for part in (one.device, one.station):
        for key, is_other in (
            ("rate", part.period != one.station.period),
            ("substeps", part.substeps != 1),
            ("feedthrough", part.feedthrough is False),
        ):
            if is_other:
                raise InputError(
                    f"{part.name} has its own '{key}', and the wall here is of a device and a "
                    "workstation that both step once in the same tick: take that away.",
                    scenario.locate(("components", part.name, key)),
                )
