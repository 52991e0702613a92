"""In real time, with a board that does not wait, what an emulated device is made of is found.

``pytest -s`` on this file prints what docs/identify.md has in its table of paced runs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import cohaptic
from cosim.cli import cli
from cosim.identification.nominal import Nominal
from cosim.identification.regressor import inertia_matrix
from cosim.identification.results import Identified
from hil.emulation.launch import Emulator, Order
from hil.emulation.mechanics import HeldForm, Mechanics
from hil.setup.device_edit import save
from tests.support.hil.driver_bench import SETUPS
from tests.support.machine import timed

SHARE = 0.02
"""Of inertia and Coulomb friction."""
LATENCY_TICKS, OFFSET = 0.1, 3e-3
COULOMB = 0.005
OFFSETS = (0.01, -0.01)
SECONDS = "30"
LATE = 2e-3
"""A machine that lets a loop wait for longer (s) has the board answer late, and time is what is
measured here."""


def command(*arguments: str) -> None:
    done = CliRunner().invoke(cli, arguments, catch_exceptions=False, standalone_mode=False)
    assert done.exit_code == 0, done.output


def identified(folder: Path, driver: str, payload: float | None) -> Identified | str:
    """What one paced run tells, or how it ended."""
    folder.mkdir()
    mechanics = Mechanics(
        payload=payload,
        hand=HeldForm(stiffness=0.0, damping=0.0),
        home_error=list(OFFSETS),
        coulomb_friction=COULOMB,
    )
    setup = SETUPS[driver]
    parameters = setup["parameters"]
    order = Order(name=driver, priority=65, parameters=parameters, mechanics=mechanics)
    file, plan, run = (folder / each for each in ("device.yaml", "plan.yaml", "run"))
    with Emulator(order) as emulator:
        written: dict[str, Any] = {"preset": "quanser", **setup["file"]}
        save(file, {"driver": driver, "home": list(emulator.home), **written})
        given = ["--url", emulator.url, "--seconds", SECONDS, "--payload", f"{payload or 0} kg"]
        command("identify", "--plan", str(file), *given, "--out", str(plan))
        output = ("--realtime", "--enable-output", "--yes", "--no-figure", "--no-report")
        arguments = ["run", str(plan), *output, "--out", str(run)]
        done = CliRunner().invoke(cli, arguments, standalone_mode=False)
    if done.exit_code != 0:
        return f"the run ended with {done.exit_code}: {done.output[-400:]}"
    return cohaptic.identify(run)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("driver", "payload"),
    [("haply", None), ("haply", 0.05), ("odrive", None), ("cia402", None)],
    ids=["haply", "haply with 50 g", "odrive", "cia402"],
)
def test_a_paced_run_tells_inertia_friction_latency_and_offsets(tmp_path, driver, payload) -> None:
    found = timed(
        lambda number: identified(tmp_path / f"attempt{number}", driver, payload), tolerates=LATE
    )
    described = found.described
    made_of = Nominal.of(described.preset, {"coulomb_friction": COULOMB}).values(described.bar)
    # The mass on the tip is known, and none of the device's.
    inertia = inertia_matrix(described.bar, found.pose) @ made_of[:5]
    print("\n" + "\n".join(str(each) for each in found.estimates))
    print(f"inertia at home: {inertia[0, 0]:.5g}, {inertia[1, 1]:.5g}; {found.counts}")
    assert found["home_11"].value == pytest.approx(inertia[0, 0], rel=SHARE)
    assert found["home_22"].value == pytest.approx(inertia[1, 1], rel=SHARE)
    assert found["coulomb_1"].value == pytest.approx(COULOMB, rel=SHARE)
    assert found["coulomb_2"].value == pytest.approx(COULOMB, rel=SHARE)
    # What a board that measures on its own clock shows is up to a tick older than what is asked.
    least = 1.0 if driver == "haply" else 0.0
    assert least - LATENCY_TICKS < found["latency"].value * 1024 < 1.0 + LATENCY_TICKS
    if driver == "haply":
        for number, offset in enumerate(OFFSETS, 1):
            assert found[f"offset_{number}"].value == pytest.approx(offset, abs=OFFSET)
