"""The check of each motor's sign: a paced run of two components, under all that guards runs."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from cosim.base.errors import RunError

if TYPE_CHECKING:
    from cosim.run import Execute

DEVICE, PROBE = "device", "probe"
RATE = 1024
"""Ticks a second."""


def torque_signs(url: str, file: Path) -> tuple[int, int]:
    """1 where a motor pushes the way that the device file says, -1 where the other.

    Whether output is allowed, and who is asked, is the current session's.

    Raises:
        RunError: the run failed, or a joint did not move.
    """
    from cosim.reading import load
    from cosim.record.reader import open_run
    from cosim.run import run_scenario

    with TemporaryDirectory(prefix="cohaptic-signs-") as name:
        folder = Path(name)
        (folder / "signs.yaml").write_text(json.dumps(_scenario(url, file.absolute())), "utf-8")
        scenario = load(folder / "signs.yaml")
        done = run_scenario(scenario, folder / "run", execute=_execute(url), figure=False)
        if done.error is not None:
            raise done.error
        with open_run(done.folder) as record:
            first, second = (int(record[f"{PROBE}.moved[{joint}]"].values[-1]) for joint in (1, 2))
    for joint, moved in enumerate((first, second)):
        if moved == 0:
            raise RunError(
                f"joint {joint + 1} did not move: is its motor connected and its supply on, and "
                "is nobody holding the handle?"
            )
    return first, second


def _execute(url: str) -> Execute | None:
    from cosim.base.system.grants import clock_nanosleep
    from cosim.cli.support.devices import say
    from cosim.realtime.paced_run import PacedRun
    from cosim.realtime.pacing import DeadlinePacer
    from hil.device.driver import find_driver
    from hil.setup.address import parse

    address = parse(url)
    if address.is_lockstep or find_driver(address.driver).in_process:
        return None
    pacer = DeadlinePacer(tick_seconds=Fraction(1, RATE), sleep=clock_nanosleep())
    return PacedRun(pacer=pacer, say=say)


def _scenario(url: str, file: Path) -> dict[str, object]:
    from hil.setup.calibrate.sign_probe import SECONDS

    return {
        "cohaptic": 1,
        "title": "Which way each motor pushes",
        "duration": round(SECONDS, 1),
        "rates": {"control": RATE},
        "components": {
            DEVICE: {"device": {"url": url, "file": str(file)}, "rate": "control"},
            PROBE: {"python": "hil.setup.calibrate.sign_probe:SignProbe", "rate": "control"},
        },
        "connections": [
            f"{DEVICE}.joint_angle -> {PROBE}.joint_angle",
            f"{PROBE}.motor_torque -> {DEVICE}.motor_torque",
        ],
        "record": [f"{DEVICE}.joint_angle", f"{DEVICE}.applied_torque", f"{PROBE}.*"],
    }
