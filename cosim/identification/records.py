"""A device's rows out of a run folder, and what the run says of a mass on the tip."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import quantity
from cosim.base.suggest import did_you_mean
from cosim.identification.five_bar import Array
from cosim.identification.samples import Recording
from cosim.record import Run, digest
from cosim.scenario import Kind, Scenario

EXCITATION = "cosim.identification.excitation.controller:Excitation"
NEEDED = ("joint_angle[1]", "joint_angle[2]", "applied_torque[1]", "applied_torque[2]")


def candidates(run: Run) -> list[str]:
    """Components of a run that have angles and torques recorded."""
    names = {name.rpartition(".")[0] for name in run.signals}
    return sorted(
        each for each in names if all(f"{each}.{signal}" in run.signals for signal in NEEDED)
    )


def component_of(run: Run, wanted: str | None) -> str:
    """The component whose device is looked at: the only one, or the one that is named.

    Raises:
        InputError: there is none, several, or not this one.
    """
    found = candidates(run)
    if not found:
        raise InputError(
            f"{run.folder} has no component with joint_angle and applied_torque in its record: "
            "record them (record: [finger.*]), of a device or of a simulated pantograph."
        )
    if wanted is None and len(found) > 1:
        raise InputError(
            f"{run.folder} has {len(found)} devices, {', '.join(found)}: name one with --component."
        )
    if wanted is not None and wanted not in found:
        raise InputError(
            f"{run.folder} has no device '{wanted}' in its record.{did_you_mean(wanted, found)}"
        )
    return wanted or found[0]


def payload_of(scenario: Scenario, component: str) -> float | None:
    """The mass (kg) on the tip of a device that a run's scenario tells, ``None`` where it does not.

    Of a device it is the one that the excitation was planned for; a simulated pantograph says by
    itself which hand it carries.
    """
    device = scenario.components.get(component)
    if device is not None and device.is_bundled and device.source == "pantograph":
        return _mass(device.parameters.get("finger_mass", _usual_hand()))
    movers = {
        each.source.component for each in scenario.connections if each.target.component == component
    }
    for name in movers:
        part = scenario.components.get(name)
        if part is not None and part.source == EXCITATION and "payload" in part.parameters:
            return _mass(part.parameters["payload"])
    return None


def _mass(value: object) -> float:
    assert isinstance(value, (int, float, str)), "one value"
    return float(quantity(value, "kg"))


def _usual_hand() -> object:
    """The mass (kg) that a simulated pantograph carries unless it is told otherwise."""
    from fmus.pantograph.variables import MODEL
    from fmus.table import ModelVariable

    return next(
        each.start
        for each in MODEL.variables
        if isinstance(each, ModelVariable) and each.name == "finger_mass"
    )


def recording(
    run: Run,
    scenario: Scenario,
    component: str,
    *,
    limit: float,
    payload: float | None,
    force: str | None,
) -> tuple[Recording, int]:
    """A run's rows, and how many base ticks lie from one to the next.

    Raises:
        InputError: a signal is missing, or not recorded at the device's rate.
    """
    group = run[f"{component}.joint_angle[1]"].group
    torque = _pair(run, f"{component}.applied_torque")
    angle = _pair(run, f"{component}.joint_angle")
    pushed = None if force is None else _pair(run, force)
    sensor = None if force is None else force.rpartition(".")[0]
    names = [f"{component}.{each}" for each in (*NEEDED, "sample_age", "status")]
    names += [] if sensor is None else [f"{force}[1]", f"{force}[2]", f"{sensor}.sample_age"]
    for name in names:
        if name in run.signals and run[name].group.name != group.name:
            raise InputError(
                f"{run.folder}: {name} is recorded at another rate than {component}.joint_angle."
            )
    rows = len(angle)
    manifest = run.manifest
    return (
        Recording(
            name=run.folder.name,
            digest=digest(run),
            date=str(manifest.get("started", ""))[:10],
            tick=float(1 / group.rate),
            ticks=group.ticks,
            angle=angle,
            torque=torque,
            age=_whole(run, scenario, component, "sample_age", otherwise=0, rows=rows),
            status=_whole(run, scenario, component, "status", otherwise=11, rows=rows),
            limit=limit,
            payload=payload,
            force=pushed,
            force_age=None
            if sensor is None
            else _whole(run, scenario, sensor, "sample_age", otherwise=0, rows=rows),
        ),
        group.period,
    )


def _pair(run: Run, name: str) -> Array:
    missing: Sequence[str] = [f"{name}[{i}]" for i in (1, 2) if f"{name}[{i}]" not in run.signals]
    if missing:
        hint = did_you_mean(missing[0], run.signals)
        raise InputError(f"{run.folder} has no signal {missing[0]} in its record.{hint}")
    return np.stack([run[f"{name}[{i}]"].values for i in (1, 2)], axis=1).astype(np.float64)


def _whole(
    run: Run, scenario: Scenario, component: str, signal: str, *, otherwise: int, rows: int
) -> NDArray[np.int64]:
    """A whole number of every row; the simulated device's constant where it is not recorded."""
    name = f"{component}.{signal}"
    if name in run.signals:
        return np.asarray(run[name].values, dtype=np.int64)
    part = scenario.components.get(component)
    if part is not None and part.kind is Kind.DEVICE:
        raise InputError(
            f"{run.folder} has no {name} in its record, so nobody knows which of its rows count: "
            f"record it (record: [{component}.*])."
        )
    return np.full(rows, otherwise, dtype=np.int64)
