"""The device file: what one particular device on one particular bench is like.

YAML (or JSON, which is YAML): driver, serial number, date, geometry, per joint direction, offset,
counts and drive, home pose, limits with the reasons for loosened ones, workspace, and
``estop: confirmed`` where a person stands by a switch that cuts the motors' power.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from datetime import date
from difflib import get_close_matches
from math import pi
from pathlib import Path
from typing import Any, cast

from cosim.base.errors import InputError
from cosim.base.show import show
from hil.device.contract import WatchdogProof
from hil.safety.conversion import TorqueDrive, VoltageDrive
from hil.safety.limits import Limits
from hil.safety.linkage import Linkage, Pair, Region

Drive = TorqueDrive | VoltageDrive

PRESETS: Mapping[str, Mapping[str, Any]] = {
    "quanser": {
        "geometry": {"proximal": 0.100, "distal": 0.165, "base": 0.085},
        "counts_per_turn": 20000,
        "drive": {"torque_constant": 0.0364, "amplifier": 0.5},
        "rest": (0.0425, 0.2),
    },
    "haply": {
        "geometry": {"proximal": 0.070, "distal": 0.090, "base": 0.038},
        "counts_per_turn": 4880,
        "drive": {},
        "limits": {"torque": 0.12},
        "rest": (0.019, 0.1),
    },
}
"""Geometry (m), counts, drive and a tip position in mid-workspace of the two published devices."""

VOLTAGE_DRIVERS = frozenset({"canopen", "nidaqmx", "quanser"})
"""Drivers whose device takes volts; the drive defaults to the preset's motor and amplifier."""

LARGEST = 1e9
"""No value of a device is as large, in any unit."""

_KEYS = (
    "cohaptic_device",
    "driver",
    "preset",
    "serial",
    "date",
    "estop",
    "geometry",
    "joints",
    "home",
    "limits",
    "loosened",
    "workspace",
    "settings",
    "watchdog_proof",
)
_JOINT_KEYS = ("direction", "offset", "counts_per_turn", "drive")
_DRIVE_KEYS = (
    "direction",
    "gear",
    "torque_constant",
    "amplifier",
    "bias",
    "low",
    "high",
    "low_code",
    "high_code",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """One proximal link: joint angle = direction * shaft angle + offset (rad)."""

    direction: int = 1
    offset: float = 0.0
    counts_per_turn: int = 20000
    drive: Drive = field(default_factory=TorqueDrive)

    @property
    def quantum(self) -> float:
        """Angle of one count (rad)."""
        return 2 * pi / self.counts_per_turn


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceFile:
    """Everything that a driver and the safety layer need to know of a device."""

    driver: str
    preset: str = "quanser"
    serial: str | None = None
    date: str | None = None
    estop_confirmed: bool = False
    linkage: Linkage
    joints: tuple[Joint, Joint]
    home: Pair | None = None
    """Joint angles (rad) of the pose in which the user holds the handle while homing."""
    limits: Limits = field(default_factory=Limits)
    loosened: Mapping[str, str] = field(default_factory=dict[str, str])
    region: Region | None = None
    settings: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """What belongs to one driver alone (node numbers, watchdog endpoints, channels)."""
    watchdog_proof: WatchdogProof | None = None
    """Written by ``cohaptic device check --enable-output``."""
    path: Path | None = None

    @property
    def quantum(self) -> float:
        """The coarser joint's count (rad)."""
        return max(joint.quantum for joint in self.joints)


def default(driver: str, preset: str | None = None) -> DeviceFile:
    """The device file of a published device as it leaves its maker: no serial, not homed."""
    return parse({"driver": driver} if preset is None else {"driver": driver, "preset": preset})


def load(path: Path) -> DeviceFile:
    """Read a device file.

    Raises:
        InputError: it cannot be read, or a value in it is unknown, missing or implausible.
    """
    from ruamel.yaml import YAML

    try:
        document: Any = YAML(typ="safe").load(path.read_text("utf-8"))  # pyright: ignore[reportUnknownMemberType]
    except OSError as error:
        raise InputError(f"the device file {path} cannot be read: {error.strerror}") from error
    except (
        Exception
    ) as error:  # of bytes that are no text, the YAML package raises more than its own
        raise InputError(f"the device file {path} is not YAML: {error}") from error
    try:
        return parse(document, path=path)
    except InputError as error:
        raise InputError(f"device file {path}: {error.message}") from error


def save(path: Path, values: Mapping[str, Any]) -> None:
    """Write a device file; it is parsed first, so a broken one is never left behind."""
    from ruamel.yaml import YAML

    parse(values)
    writer = YAML()
    writer.default_flow_style = False
    with path.open("w", encoding="utf-8") as stream:
        writer.dump(dict(values), stream)  # pyright: ignore[reportUnknownMemberType]


def add_watchdog_proof(path: Path, proof: WatchdogProof) -> None:
    """Note a proof in a device file; everything else in it stays, comments included."""
    from ruamel.yaml import YAML

    editor = YAML()
    document: Any = editor.load(path.read_text("utf-8"))  # pyright: ignore[reportUnknownMemberType]
    document["watchdog_proof"] = {k: v for k, v in asdict(proof).items() if v is not None}
    if proof.serial is not None:
        document.setdefault("serial", proof.serial)
    parse(document)
    with path.open("w", encoding="utf-8") as stream:
        editor.dump(document, stream)  # pyright: ignore[reportUnknownMemberType]


def parse(document: object, path: Path | None = None) -> DeviceFile:
    """The device file in a mapping that was read from YAML.

    Raises:
        InputError: as :func:`load`.
    """
    values = _mapping("the device file", document)
    _known("key", values, _KEYS)
    driver = values.get("driver")
    if not isinstance(driver, str):
        raise InputError("'driver' has to name the driver, for example 'driver: haply'")
    preset = str(values.get("preset", "haply" if driver == "haply" else "quanser"))
    if preset not in PRESETS:
        raise InputError(f"the preset '{preset}' is unknown; there are {', '.join(PRESETS)}")
    base = PRESETS[preset]
    geometry = {**base["geometry"], **_mapping("geometry", values.get("geometry", {}))}
    _known("geometry", geometry, ("proximal", "distal", "base"))
    lengths = {name: _number(f"geometry.{name}", value) for name, value in geometry.items()}
    if lengths["proximal"] <= 0 or lengths["distal"] <= 0 or lengths["base"] < 0:
        raise InputError("the link lengths in 'geometry' have to be positive (m)")
    linkage = Linkage(**lengths)
    standard: dict[str, Any] = {}
    if driver in VOLTAGE_DRIVERS:
        standard = base["drive"] or PRESETS["quanser"]["drive"]
    if driver == "mock" and "home" not in values:
        values["home"] = list(linkage.angles(base["rest"]) or ())
    loosened = {k: str(v) for k, v in _mapping("loosened", values.get("loosened", {})).items()}
    limits = {
        name: _number(f"limits.{name}", value)
        for name, value in _mapping("limits", values.get("limits", {})).items()
    }
    return DeviceFile(
        driver=driver,
        preset=preset,
        serial=None if values.get("serial") is None else str(values["serial"]),
        date=_date(values.get("date")),
        estop_confirmed=_estop(values.get("estop")),
        linkage=linkage,
        joints=_joints(values.get("joints"), base["counts_per_turn"], standard),
        home=_home(values.get("home"), linkage),
        limits=Limits(**base.get("limits", {})).replaced(limits, loosened),
        loosened=loosened,
        region=_region(values.get("workspace")),
        settings=_mapping("settings", values.get("settings", {})),
        watchdog_proof=_watchdog_proof(values.get("watchdog_proof")),
        path=path,
    )


def _joints(
    document: object, counts_per_turn: int, standard: Mapping[str, Any]
) -> tuple[Joint, Joint]:
    if document is None:
        document = cast("list[object]", [{}, {}])
    if not isinstance(document, list) or len(cast("list[object]", document)) != 2:
        raise InputError("'joints' has to be a list of two joints")
    parsed: list[Joint] = []
    for number, item in enumerate(cast("list[object]", document), start=1):
        where = f"joints[{number}]"
        joint = _mapping(where, item)
        _known(where, joint, _JOINT_KEYS)
        counts = _number(f"{where}.counts_per_turn", joint.get("counts_per_turn", counts_per_turn))
        drive = {**standard, **_mapping(f"{where}.drive", joint.get("drive", {}))}
        if not 16 <= counts <= 2**24 or counts != int(counts):
            raise InputError(f"'{where}.counts_per_turn' is implausible: {counts}")
        offset = _number(f"{where}.offset", joint.get("offset", 0.0))
        if abs(offset) > 4 * pi:
            raise InputError(f"'{where}.offset' is an angle in rad; {offset} is implausible")
        parsed.append(
            Joint(
                direction=_direction(f"{where}.direction", joint.get("direction", 1)),
                offset=offset,
                counts_per_turn=int(counts),
                drive=_drive(f"{where}.drive", drive),
            )
        )
    return parsed[0], parsed[1]


def _drive(where: str, values: Mapping[str, Any]) -> Drive:
    _known(where, values, _DRIVE_KEYS)
    direction = _direction(f"{where}.direction", values.get("direction", 1))
    numbers = {
        name: _number(f"{where}.{name}", value)
        for name, value in values.items()
        if name != "direction"
    }
    for name in ("gear", "torque_constant", "amplifier"):
        if not numbers.get(name, 1.0) > 0:
            raise InputError(f"'{where}.{name}' has to be positive; the sign is 'direction'")
    if "torque_constant" not in numbers and "amplifier" not in numbers:
        _known(where, numbers, ("gear",))
        return TorqueDrive(direction=direction, gear=numbers.get("gear", 1.0))
    for name in ("torque_constant", "amplifier"):
        if name not in numbers:
            raise InputError(f"'{where}' gives one of torque_constant and amplifier, it needs both")
    codes = {name: int(numbers.pop(name)) for name in ("low_code", "high_code") if name in numbers}
    drive = VoltageDrive(direction=direction, **numbers, **codes)
    if not drive.low <= drive.bias <= drive.high or drive.low_code >= drive.high_code:
        raise InputError(f"'{where}': the bias has to lie inside the DAC's range")
    return drive


def _home(document: object, linkage: Linkage) -> Pair | None:
    if document is None:
        return None
    if not isinstance(document, list) or len(cast("list[object]", document)) != 2:
        raise InputError("'home' has to be two joint angles in rad")
    first, second = (_number("home", value) for value in cast("list[object]", document))
    if linkage.tip((first, second)) is None:
        raise InputError(f"the links cannot meet at the home pose [{first}, {second}] rad")
    return first, second


def _region(document: object) -> Region | None:
    if document is None:
        return None
    edges = _mapping("workspace", document)
    _known("workspace", edges, ("left", "right", "bottom", "top"))
    if len(edges) != 4:
        raise InputError("'workspace' needs left, right, bottom and top (m, device frame)")
    region = Region(**{name: _number(f"workspace.{name}", value) for name, value in edges.items()})
    if region.left >= region.right or region.bottom >= region.top:
        raise InputError("'workspace' is empty: left < right and bottom < top are needed")
    return region


def _watchdog_proof(document: object) -> WatchdogProof | None:
    if document is None:
        return None
    values = _mapping("watchdog_proof", document)
    _known("watchdog_proof", values, ("date", "serial", "timeout", "fired_after"))
    proved = _date(values.get("date"))
    if proved is None:
        raise InputError("'watchdog_proof' needs the date on which the watchdog was seen to fire")
    return WatchdogProof(
        date=proved,
        timeout=_number("watchdog_proof.timeout", values.get("timeout")),
        fired_after=_number("watchdog_proof.fired_after", values.get("fired_after")),
        serial=None if values.get("serial") is None else str(values["serial"]),
    )


def _estop(value: object) -> bool:
    if value not in (None, "confirmed", "none"):
        raise InputError("'estop' is either 'confirmed' or left out")
    return value == "confirmed"


def _date(value: object) -> str | None:
    return value.isoformat() if isinstance(value, date) else None if value is None else str(value)


def _direction(where: str, value: object) -> int:
    if value not in (1, -1):
        raise InputError(f"'{where}' has to be 1 or -1, it is {show(value)}")
    return 1 if value == 1 else -1


def _number(where: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < LARGEST:
        raise InputError(f"'{where}' has to be a number, it is {show(value)}")
    return float(value)


def _mapping(where: str, value: object) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise InputError(f"'{where}' has to be a mapping of names to values")
    return {str(key): item for key, item in cast("Mapping[object, Any]", value).items()}


def _known(where: str, values: Mapping[str, Any], known: tuple[str, ...]) -> None:
    for name in values:
        if name not in known:
            close = get_close_matches(name, known, 1)
            hint = f"; did you mean '{close[0]}'?" if close else f"; there are {', '.join(known)}"
            raise InputError(f"unknown {where} '{name}'{hint}")
