"""What a device file may say, beyond what each of its keys may: nothing that no device is like.

A limit, a gear, a torque constant and the motor's rating have to fit together, because a slip of
a unit in any of them turns a tenth of a newton metre into whatever the amplifier gives.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isclose

from hil.safety.conversion import TorqueDrive, VoltageDrive
from hil.safety.limits import Limits
from hil.safety.linkage import Linkage, Pair, Region
from hil.setup.preset import Motor

Path = tuple[str | int, ...]
Finding = tuple[Path, str]
"""Where in the file, and what is wrong there."""
BIAS_SHARE = 0.1
"""How far from the middle of a DAC's range (as a share of it) the voltage without torque may be."""


def judge_drives(
    drives: Sequence[TorqueDrive | VoltageDrive], limits: Limits, motor: Motor
) -> Iterator[Finding]:
    """What is wrong with the joints' drives at these limits, for a motor of this rating."""
    for index, drive in enumerate(drives):
        path = ("joints", index, "drive")
        rated = (("torque", motor.peak_torque), ("continuous_torque", motor.continuous_torque))
        for name, rating in rated:
            asked = getattr(limits, name)
            if _exceeds(asked, rating * drive.gear):
                said = (
                    f"limits.{name}: {asked:g} N.m is more than the motor of joint {index + 1} is "
                    f"rated for ({rating:g} N.m with a gear of {drive.gear:g}): tighten the limit, "
                    "or write the rating of your motor under 'motor'."
                )
                yield ("limits", name), said
        if isinstance(drive, VoltageDrive):
            yield from _judge_volts(path, drive, limits.torque, motor)


def _judge_volts(path: Path, drive: VoltageDrive, torque: float, motor: Motor) -> Iterator[Finding]:
    where = ".".join(map(str, path))
    middle, span = (drive.low + drive.high) / 2, drive.high - drive.low
    if span <= 0.0 or drive.low_code >= drive.high_code:
        yield path, f"{where}: low < high and low_code < high_code are needed."
        return
    if abs(drive.bias - middle) > BIAS_SHARE * span:
        said = (
            f"{where}.bias: {drive.bias:g} V is the voltage without torque, and has to lie near "
            f"the middle of the DAC's range ({middle:g} V, give or take {BIAS_SHARE * span:g})."
        )
        yield (*path, "bias"), said
    current = torque / (drive.torque_constant * drive.gear)
    if motor.peak_current is not None and _exceeds(current, motor.peak_current):
        said = (
            f"{where}: the torque limit of {torque:g} N.m asks for {current:.3g} A of a motor that "
            f"takes {motor.peak_current:g} A at most: torque_constant (N.m/A) or gear is wrong, or "
            "the motor is another one (write its rating under 'motor')."
        )
        yield path, said
    volts = current / drive.amplifier
    room = min(drive.high - drive.bias, drive.bias - drive.low)
    if _exceeds(volts, room):
        reached = torque * max(room, 0.0) / volts
        said = (
            f"{where}: the torque limit of {torque:g} N.m asks for {volts:.3g} V beyond the bias, "
            f"and the DAC has {room:g} V there: torque_constant, gear or amplifier is wrong, or "
            f"'limits: {{torque: {reached:.2g}}}' is all that this drive can give."
        )
        yield path, said


def judge_workspace(
    linkage: Linkage, region: Region, limits: Limits, home: Pair | None
) -> Iterator[Finding]:
    """What is wrong with where the tip may be, and with where it is homed."""
    if home is None:
        middle = ((region.left + region.right) / 2, (region.bottom + region.top) / 2)
        if linkage.angles(middle) is None:
            said = (
                f"workspace: its middle ({_millimetres(middle)}) is out of the linkage's reach; "
                "compare it with 'geometry'."
            )
            yield ("workspace",), said
        return
    tip = linkage.tip(home)
    first, second = home
    if tip is None:
        yield ("home",), f"the links cannot meet at the home pose [{first}, {second}] rad."
        return
    if not region.contains(tip):
        said = (
            f"home: the tip is at {_millimetres(tip)} there, outside the workspace (x from "
            f"{region.left * 1e3:.0f} to {region.right * 1e3:.0f}, y from "
            f"{region.bottom * 1e3:.0f} to {region.top * 1e3:.0f} mm)."
        )
        yield ("home",), said
    elif linkage.dexterity(home, tip) < limits.dexterity:
        said = (
            f"home: [{first}, {second}] rad is nearer to a singular position than the limit "
            f"'dexterity: {limits.dexterity:g}' allows."
        )
        yield ("home",), said


def _exceeds(value: float, bound: float) -> bool:
    return value > bound and not isclose(value, bound, rel_tol=1e-9)


def _millimetres(point: Pair) -> str:
    return f"x {point[0] * 1e3:.0f}, y {point[1] * 1e3:.0f} mm"
