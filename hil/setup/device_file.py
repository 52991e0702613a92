"""The device file: what one particular device on one particular bench is like.

YAML (or JSON, which is YAML), read by the form in ``hil.setup.device_form`` and completed by what
its maker publishes; ``settings`` are read by the form of the driver that it names.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from cosim.base.document.node import Node
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError, Location
from hil.device.contract import WatchdogProof
from hil.safety.conversion import TorqueDrive, VoltageDrive
from hil.safety.limits import Limits
from hil.safety.linkage import Linkage, Pair, Region

if TYPE_CHECKING:
    from hil.setup.device_form import DeviceFileForm, DriveForm, JointForm
from hil.setup.driver_facts import DriverSettings
from hil.setup.plausibility import judge_drives, judge_workspace
from hil.setup.preset import Motor
from hil.setup.registry import find, find_preset

Drive = TorqueDrive | VoltageDrive
S = TypeVar("S", bound="DriverSettings")


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
    motor: Motor
    joints: tuple[Joint, Joint]
    home: Pair | None = None
    """Joint angles (rad) of the pose in which the user holds the handle while homing."""
    limits: Limits = field(default_factory=Limits)
    loosened: Mapping[str, str] = field(default_factory=dict[str, str])
    region: Region | None = None
    settings: DriverSettings | None = None
    """What belongs to one driver alone (node numbers, watchdog endpoints, channels)."""
    watchdog_proof: WatchdogProof | None = None
    """Written by ``cohaptic device check --enable-output``."""
    path: Path | None = None

    @property
    def quantum(self) -> float:
        """The coarser joint's count (rad)."""
        return max(joint.quantum for joint in self.joints)

    def settings_of(self, form: type[S]) -> S:
        """The settings in the driver's own form; its defaults where the file gives none."""
        return self.settings if isinstance(self.settings, form) else form()


def default(driver: str, preset: str | None = None) -> DeviceFile:
    """The device file of a published device as it leaves its maker: no serial, not homed."""
    return parse({"driver": driver} if preset is None else {"driver": driver, "preset": preset})


def load(path: Path) -> DeviceFile:
    """Read a device file.

    Raises:
        InputError: it cannot be read, or values in it are unknown, missing or implausible: all of
            them, each with its place.
    """
    from cosim.base.document.yaml_reader import read_yaml

    try:
        root = read_yaml(path, str(path))
    except InputError as error:
        if error.location is not None:
            raise
        raise InputError(f"the device file {path} cannot be used: {error.message}") from error
    return _read(root, path)


def parse(document: object) -> DeviceFile:
    """The device file in plain data, as :func:`load` finds it in a file.

    Raises:
        InputError: as :func:`load`.
    """
    from cosim.base.document.form import plain_node

    return _read(plain_node(document, Location("the device file", 0, 0)), None)


def _read(root: Node, path: Path | None) -> DeviceFile:
    from cosim.base.document.form import check_form
    from hil.setup.settings import form_with_settings

    written = root.text("driver")
    problems = Problems(root, subject="a device file")
    kind = form_with_settings(written, problems)
    problems = problems.of(kind)
    form = check_form(kind, root, problems)
    problems.raise_if_any()
    assert form is not None, "what is no form has a problem"
    return _Builder(form, problems).build(path)


class _Builder:
    """Completes the form by its preset, and judges what only fits together."""

    def __init__(self, form: DeviceFileForm, problems: Problems) -> None:
        self._form = form
        self._problems = problems
        self._kind = find(form.driver)
        self._name = form.preset or self._kind.preset
        with problems.at(("preset",)):
            self._preset = find_preset(self._name, self._kind)
        problems.raise_if_any()

    def build(self, path: Path | None) -> DeviceFile:
        form = self._form
        linkage = replace(self._preset.linkage, **form.geometry.model_dump(exclude_none=True))
        joints = self._joints()
        loosened = form.loosened.model_dump(exclude_none=True)
        limits = self._limits(loosened)
        region = self._region(linkage, loosened)
        home = self._home(linkage)
        self._problems.raise_if_any()
        motor = replace(self._preset.motor, **form.motor.model_dump(exclude_none=True))
        for at, sentence in (
            *judge_drives([joint.drive for joint in joints], limits, motor),
            *judge_workspace(linkage, region or linkage.default_region(), limits, home),
        ):
            self._problems.add(at, sentence)
        self._problems.raise_if_any()
        proof = form.watchdog_proof
        return DeviceFile(
            driver=form.driver,
            preset=self._name,
            serial=form.serial,
            date=form.date,
            estop_confirmed=form.estop == "confirmed",
            linkage=linkage,
            motor=motor,
            joints=joints,
            home=home,
            limits=limits,
            loosened=loosened,
            region=region,
            settings=form.settings,
            watchdog_proof=None if proof is None else WatchdogProof(**proof.model_dump()),
            path=path,
        )

    def _limits(self, loosened: Mapping[str, str]) -> Limits:
        standard = Limits(**self._preset.limits)
        given = self._form.limits.given()
        for name, value in given.items():
            if standard.is_looser(name, value) and name not in loosened:
                self._problems.add(("limits", name), standard.needs_a_reason(name, value))
        for name in loosened:
            if name == "workspace":
                continue
            value = given.get(name)
            if value is None or not standard.is_looser(name, value):
                self._problems.add(
                    ("loosened", name),
                    f"loosened.{name}: the limit is not looser than the default "
                    f"{getattr(standard, name)}; leave the reason out.",
                )
        limits = standard.replaced(given)
        for name, sentence in limits.beyond_ceilings().items():
            self._problems.add(("limits", name), sentence)
        return limits

    def _region(self, linkage: Linkage, loosened: Mapping[str, str]) -> Region | None:
        form = self._form.workspace
        region = None if form is None else Region(**form.model_dump())
        standard = linkage.default_region()
        looser = region is not None and not region.is_within(standard)
        if looser and "workspace" not in loosened:
            self._problems.add(
                ("workspace",),
                "workspace: it reaches beyond the default, x from "
                f"{standard.left * 1e3:.0f} to {standard.right * 1e3:.0f}, y from "
                f"{standard.bottom * 1e3:.0f} to {standard.top * 1e3:.0f} mm: write why under "
                "'loosened: {workspace: ...}', or make it smaller.",
            )
        if not looser and "workspace" in loosened:
            self._problems.add(
                ("loosened", "workspace"),
                "loosened.workspace: the workspace does not reach beyond the default; leave the "
                "reason out.",
            )
        return region

    def _home(self, linkage: Linkage) -> Pair | None:
        if self._form.home is not None:
            first, second = self._form.home
            return first, second
        return linkage.angles(self._preset.rest) if self._form.driver == "mock" else None

    def _joints(self) -> tuple[Joint, Joint]:
        from hil.setup.device_form import JointForm

        first, second = self._form.joints or [JointForm(), JointForm()]
        return self._joint(0, first), self._joint(1, second)

    def _joint(self, index: int, form: JointForm) -> Joint:
        return Joint(
            direction=form.direction,
            offset=form.offset,
            counts_per_turn=form.counts_per_turn or self._preset.counts_per_turn,
            drive=self._drive(("joints", index, "drive"), form.drive),
        )

    def _drive(self, path: tuple[str | int, ...], form: DriveForm) -> Drive:
        given = form.model_dump(exclude_none=True, exclude_unset=True)
        where = ".".join(map(str, path))
        unit = self._kind.command_unit
        if unit == "N.m" or (unit is None and not given.keys() & {"torque_constant", "amplifier"}):
            for name in given.keys() - {"direction", "gear"}:
                self._problems.add(
                    (*path, name),
                    f"{where}.{name}: it belongs to a drive that takes volts, and the driver "
                    f"'{self._form.driver}' is given the motor's torque.",
                )
            return TorqueDrive(direction=form.direction, gear=form.gear)
        standard: Mapping[str, Any] = {}
        if unit == "V":
            standard = self._preset.drive or find_preset("quanser", self._kind).drive
        values = {**standard, **given}
        for name in ("torque_constant", "amplifier"):
            if name not in values:
                self._problems.add(
                    path, f"{where}: one of torque_constant and amplifier; it needs both."
                )
                return TorqueDrive()
        return VoltageDrive(**values)
