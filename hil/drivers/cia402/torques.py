"""Torques of two joints as two drives take them: thousandths of what each is rated for."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from cosim.base.errors import InputError
from hil.device.errors import DeviceError
from hil.safety.conversion import TorqueDrive
from hil.safety.linkage import Pair
from hil.setup.device_file import DeviceFile

COARSEST = 0.1
"""Largest step of torque as a share of the limit: a larger one is felt."""
LARGEST_CODE = 32767
RECENT = 8
"""Commands of which a drive's torque demand may be one: it takes a tick or more to show it."""
SLACK = 5
"""Thousandths of the rated torque by which a demand may differ besides: drives round, too."""

Codes = tuple[int, int]


class DriveTorques:
    """What two drives are given, and whether what they demand is any of it.

    Raises:
        InputError: the file's drives take something else than torque.
    """

    def __init__(self, file: DeviceFile) -> None:
        self._drives = _drive(file, 0), _drive(file, 1)
        self._limit = file.limits.torque
        self.rated: Pair = (1.0, 1.0)
        """Of each drive (N.m), as it says itself."""
        self.forget()

    def forget(self) -> None:
        """The drives were switched on: nothing was given yet."""
        self._recent = tuple(deque[int]((0,), maxlen=RECENT) for _ in (0, 1))

    def refuse_coarse(self, nodes: Sequence[int]) -> None:
        """Refuse drives whose thousandth can be felt.

        Raises:
            DeviceError: one of them, by its node number.
        """
        for node, drive, rated in zip(nodes, self._drives, self.rated, strict=True):
            step = rated * 1e-3 * drive.gear
            if step > COARSEST * self._limit:
                raise DeviceError(
                    f"CiA 402 drive {node} is rated {rated:g} N.m, a thousandth of which is "
                    f"{step * 1e3:.3g} mN.m at the joint: too coarse for a limit of "
                    f"{self._limit:g} N.m"
                )

    def codes(self, torque: Pair) -> Codes:
        """Thousandths of the rated torques, rounded toward zero."""
        return self._code(0, torque[0]), self._code(1, torque[1])

    def _code(self, joint: int, torque: float) -> int:
        wanted = self._drives[joint].encode(torque) / self.rated[joint] * 1e3
        return max(-LARGEST_CODE, min(LARGEST_CODE, int(wanted)))

    def given_by(self, codes: Codes) -> Pair:
        """Joint torques (N.m) of such codes."""
        first, second = (
            drive.decode(code * 1e-3 * rated)
            for drive, code, rated in zip(self._drives, codes, self.rated, strict=True)
        )
        return first, second

    def sent(self, codes: Codes) -> None:
        """The drives are told these."""
        for code, recent in zip(codes, self._recent, strict=True):
            recent.append(code)

    def astray(self, nodes: Sequence[int], demands: Sequence[int]) -> str:
        """A torque demand that is none of what its drive was told of late; empty: there is none."""
        for node, demand, recent in zip(nodes, demands, self._recent, strict=True):
            if not min(recent) - SLACK <= demand <= max(recent) + SLACK:
                return (
                    f"CiA 402 drive {node} demands {demand} thousandths of its rated torque "
                    f"(6074h) and was told {recent[-1]}"
                )
        return ""


def _drive(file: DeviceFile, joint: int) -> TorqueDrive:
    drive = file.joints[joint].drive
    if not isinstance(drive, TorqueDrive):
        raise InputError(
            "a CiA 402 drive takes torque: its 'drive' has a gear and a direction only"
        )
    return drive
