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
SECONDS = "40"
TIMES = {"tolerates": 2e-3}
"""A machine that lets a loop wait for longer (s) has the board answer late, and time is what is
measured here."""


def command(*arguments: str) -> None:
    done = CliRunner().invoke(cli, arguments, catch_exceptions=False, standalone_mode=False)
    assert done.exit_code == 0, done.output


def excited(folder: Path, driver: str, payload: float) -> Path | str:
    """One planned run in real time, or how it ended."""
    folder.mkdir(parents=True)
    mechanics = Mechanics(
        payload=payload or None,
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
        given = ["--url", emulator.url, "--seconds", SECONDS, "--payload", f"{payload} kg"]
        command("identify", "--plan", str(file), *given, "--out", str(plan))
        output = ("--realtime", "--enable-output", "--yes", "--no-figure", "--no-report")
        arguments = ["run", str(plan), *output, "--out", str(run)]
        done = CliRunner().invoke(cli, arguments, standalone_mode=False)
    return run if done.exit_code == 0 else f"the run ended with {done.exit_code}: {done.output}"


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("driver", "payloads"), [("haply", (0.0, 0.05)), ("odrive", (0.0,)), ("cia402", (0.0,))]
)
def test_paced_runs_tell_inertia_friction_latency_and_offsets(tmp_path, driver, payloads) -> None:
    runs = [
        timed(lambda number, put=put: excited(tmp_path / f"{put}-{number}", driver, put), **TIMES)
        for put in payloads
    ]
    found = cohaptic.identify(*runs)
    described = found.described
    made_of = Nominal.of(described.preset, {"coulomb_friction": COULOMB}).values(described.bar)
    # The mass on the tip is known, and none of the device's.
    inertia = inertia_matrix(described.bar, found.pose) @ made_of[:5]
    print("\n" + "\n".join(str(each) for each in found.estimates))
    print(f"inertia at home: {inertia[0, 0]:.5g}, {inertia[1, 1]:.5g}; {found.counts}")
    for number in (1, 2):
        home = inertia[number - 1, number - 1]
        assert found[f"home_{number}{number}"].value == pytest.approx(home, rel=SHARE)
        assert found[f"coulomb_{number}"].value == pytest.approx(COULOMB, rel=SHARE)
    # What a board shows that nobody asks is as old as its clock lies beside the run's, up to a
    # tick, and what its bus keeps back.
    least, most = (1.0, 1.0) if driver == "haply" else (0.0, 1.5)
    assert least - LATENCY_TICKS < found["latency"].value * 1024 < most + LATENCY_TICKS
    for number in (1, 2) if len(payloads) > 1 else ():
        assert found[f"offset_{number}"].value == pytest.approx(OFFSETS[number - 1], abs=OFFSET)
        assert found[f"gain_{number}"].value == pytest.approx(1.0, rel=SHARE)
