"""What ``cohaptic check`` says of a scenario's devices: latency, bus loads, gains."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from cosim.base.errors import InputError
from cosim.scenario import Kind, Scenario

if TYPE_CHECKING:
    from cosim.master.run.simulation import Simulation
    from hil.device.component import DeviceComponent


def check_devices(scenario: Scenario, simulation: Simulation) -> dict[str, Any]:
    """Facts for the report, and sentences under ``warnings``; nothing is opened.

    Raises:
        InputError: a CAN bus cannot carry the scenario's devices.
    """
    written = [name for name, part in scenario.components.items() if part.kind is Kind.DEVICE]
    if not written:
        return {"devices": {}, "buses": [], "warnings": []}
    from cosim.analysis.device_latency import latency_warnings
    from hil.device.component import DeviceComponent
    from hil.wire.bus_plan import plan_buses

    devices: dict[str, tuple[DeviceComponent, Fraction]] = {}
    for name in written:
        participant = simulation.assembly.participants[name]
        if isinstance(participant.component, DeviceComponent):
            rate = scenario.base_rate / participant.period
            devices[name] = (participant.component, rate)
    buses: list[dict[str, Any]] = []
    for bus in plan_buses(devices):
        try:
            load = bus.load()
        except InputError as error:
            place = scenario.locate(("components", next(iter(bus.users)), "device"))
            raise InputError(error.message, place) from None
        buses.append(
            {
                "name": bus.name,
                "devices": list(bus.users),
                "frames_per_tick": len(bus.sizes),
                "rate": float(bus.rate),
                "bitrate": bus.bitrate,
                "load": load.plain,
                "worst_load": load.worst,
            }
        )
    latency = {name: component.kind.latency_ticks for name, (component, _) in devices.items()}
    return {
        "devices": {
            name: {
                "url": component.address.url,
                "latency_ticks": latency[name],
                "file": _file(component),
            }
            for name, (component, _) in devices.items()
        },
        "buses": buses,
        "warnings": latency_warnings(scenario, latency),
    }


def _file(component: DeviceComponent) -> dict[str, Any]:
    """What its device file says, and what holds of its limits and the scenario's."""
    from dataclasses import asdict

    file = component.file
    return {
        "path": None if file.path is None else str(file.path),
        "preset": file.preset,
        "serial": file.serial,
        "date": file.date,
        "estop_confirmed": file.estop_confirmed,
        "watchdog_proof": None if file.watchdog_proof is None else asdict(file.watchdog_proof),
        "limits": {
            name: {"value": value, "from": "safety" if name in component.tightened else "device"}
            for name, value in asdict(file.limits).items()
        },
    }


def limit_rows(report: dict[str, Any]) -> list[list[str]]:
    """The table of limits: the tighter of a device's own and the scenario's ``safety:``."""
    return [
        [
            name,
            ", ".join(
                f"{limit} {facts['value']:g}{' (safety)' if facts['from'] == 'safety' else ''}"
                for limit, facts in device["file"]["limits"].items()
            ),
        ]
        for name, device in report["devices"].items()
    ]


def proof_rows(report: dict[str, Any]) -> list[list[str]]:
    """The table of device files: which device, of when, and what was seen of its watchdog."""
    rows: list[list[str]] = []
    for name, device in report["devices"].items():
        file = device["file"]
        if file["path"] is None:
            continue
        proof = file["watchdog_proof"]
        seen = "" if proof is None else f"watchdog seen to fire on {proof['date']} after "
        seen += "" if proof is None else f"{proof['fired_after'] * 1e3:g} ms"
        serial = f"serial {file['serial']}" if file["serial"] else "no serial"
        rows.append([name, file["path"], serial, file["date"] or "no date", seen])
    return rows


def device_rows(report: dict[str, Any]) -> list[list[str]]:
    """The table of devices."""
    return [
        [name, facts["url"], f"latency in ticks: {facts['latency_ticks']}"]
        for name, facts in report["devices"].items()
    ]


def bus_rows(report: dict[str, Any]) -> list[list[str]]:
    """The table of CAN buses."""
    return [
        [
            bus["name"],
            ", ".join(bus["devices"]),
            f"{bus['frames_per_tick']} frames at {bus['rate']:g} Hz",
            f"{bus['load']:.0%} of {bus['bitrate'] / 1e6:g} Mbit/s",
            f"{bus['worst_load']:.0%} with worst-case stuffing",
        ]
        for bus in report["buses"]
    ]
