"""What is judged of a scenario's devices before any is opened: geometry, bus loads, gains."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from cosim.base.errors import InputError
from cosim.scenario import Kind, Scenario

if TYPE_CHECKING:
    from cosim.base.document.problems import Problems
    from cosim.master.run.simulation import Simulation
    from hil.device.component import DeviceComponent
    from hil.sensing.component import SensorComponent
    from hil.sensing.sensor_file import SensorFile
    from hil.setup.device_file import DeviceFile
    from hil.wire.bus_plan import Placed

Devices = dict[str, tuple["DeviceComponent", Fraction]]
"""Each device that pushes, with its control rate (Hz)."""
AllDevices = dict[str, tuple["Placed", Fraction]]
"""Those and the sensors."""


@dataclass(slots=True)
class DeviceJudge:
    """Judges a scenario's devices for a run; ``facts`` are for the report afterwards.

    ``realtime`` says whether the run is paced, ``output`` whether devices may push; ``None`` where
    nobody knows yet.
    """

    realtime: bool | None = None
    output: bool | None = False
    facts: dict[str, Any] = field(default_factory=lambda: {"devices": {}, "buses": []})

    def __call__(self, scenario: Scenario, simulation: Simulation) -> list[str]:
        """Return warnings.

        Raises:
            InputError: a device cannot be used as the scenario wants to.
        """
        if all(part.kind is not Kind.DEVICE for part in scenario.components.values()):
            return []
        from cosim.analysis.device_latency import latency_warnings
        from cosim.base.document.problems import Problems
        from cosim.preparation.device_geometry import Lengths, judge_geometry

        everything = _devices(scenario, simulation)
        devices = _pushing(everything)
        problems = Problems(scenario.root)
        lengths = {
            name: Lengths(
                component.file.linkage.proximal,
                component.file.linkage.distal,
                component.file.linkage.base,
            )
            for name, (component, _) in devices.items()
        }
        judge_geometry(simulation.assembly, lengths, problems)
        self._refuse_unpaced(everything, problems)
        slow = self._too_slow(devices, problems)
        _refuse_shared_places(everything, problems)
        self.facts["buses"] = _buses(everything, problems)
        problems.raise_if_any()
        latency = {
            name: component.kind.latency_of(component.address)
            for name, (component, _) in devices.items()
        }
        self.facts["devices"] = {
            name: {
                "url": component.address.url,
                "latency_ticks": component.kind.latency_of(component.address),
                "needs_realtime": _lives_in_real_time(component),
                "file": _facts_of_file(component),
            }
            for name, (component, _) in everything.items()
        }
        return [*slow, *latency_warnings(scenario, latency)]

    def _refuse_unpaced(self, devices: AllDevices, problems: Problems) -> None:
        """A device that lives in real time needs a paced run."""
        for name, (component, _) in devices.items():
            if _lives_in_real_time(component) and self.realtime is False:
                with problems.at(("components", name)):
                    raise InputError(
                        f"{name} is a real device ({component.address.url}): run it with --realtime"
                    )

    def _too_slow(self, devices: Devices, problems: Problems) -> list[str]:
        """Devices whose control rate is too low for any force: refused where they are to push."""
        from hil.safety.limits import too_slow_to_drop

        warnings: list[str] = []
        for name, (_, rate) in devices.items():
            found = too_slow_to_drop(float(1 / rate))
            if found is not None and self.output:
                with problems.at(("components", name, "rate")):
                    raise InputError(f"{name} {found}")
            if found is not None and self.output is None:
                warnings.append(f"{name} {found}")
        return warnings


def _refuse_shared_places(devices: AllDevices, problems: Problems) -> None:
    from hil.wire.bus_plan import refuse_shared_place

    for name in devices:
        with problems.at(("components", name, "device")):
            refuse_shared_place(name, devices)


def _lives_in_real_time(component: Placed) -> bool:
    return not (component.kind.in_process or component.lockstep)


def _devices(scenario: Scenario, simulation: Simulation) -> AllDevices:
    from hil.device.component import DeviceComponent
    from hil.sensing.component import SensorComponent

    found: AllDevices = {}
    for name, participant in simulation.assembly.participants.items():
        if isinstance(participant.component, DeviceComponent | SensorComponent):
            found[name] = (participant.component, scenario.base_rate / participant.period)
    return found


def _pushing(everything: AllDevices) -> Devices:
    """Those that take the place of a pantograph."""
    from hil.device.component import DeviceComponent

    return {
        name: (component, rate)
        for name, (component, rate) in everything.items()
        if isinstance(component, DeviceComponent)
    }


def _buses(devices: AllDevices, problems: Problems) -> list[dict[str, Any]]:
    from hil.wire.bus_plan import plan_buses

    found: list[dict[str, Any]] = []
    for bus in plan_buses(devices):
        with problems.at(("components", next(iter(bus.users)), "device")):
            load = bus.load()
            found.append(
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
    return found


def _facts_of_file(component: Placed) -> dict[str, Any]:
    from hil.device.component import DeviceComponent

    pushes = isinstance(component, DeviceComponent)
    return _file(component) if pushes else _sensor_file(component)


def _sensor_file(component: SensorComponent) -> dict[str, Any]:
    """What a sensor's file says; nothing of it is a limit."""
    return {**_origin(component.file), "watchdog_proof": None, "limits": {}}


def _origin(file: DeviceFile | SensorFile) -> dict[str, Any]:
    """Which file it is, and of what."""
    return {
        "path": None if file.path is None else str(file.path),
        "preset": file.preset,
        "serial": file.serial,
        "date": file.date,
    }


def _file(component: DeviceComponent) -> dict[str, Any]:
    """What its device file says, and what holds of its limits and the scenario's."""
    from dataclasses import asdict

    file = component.file
    return {
        **_origin(file),
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
        if device["file"]["limits"]
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
        [
            name,
            facts["url"],
            f"latency in ticks: {facts['latency_ticks']}",
            "needs --realtime" if facts["needs_realtime"] else "",
        ]
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
