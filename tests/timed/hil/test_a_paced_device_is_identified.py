"""In real time, with a board that does not wait, what an emulated Haply is made of is found."""

from __future__ import annotations

from pathlib import Path

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
from tests.support.identification.known import HAPLY, HOME
from tests.support.machine import timed

SHARE = 0.02
"""Of inertia and Coulomb friction."""
LATENCY_TICKS, OFFSET = 0.1, 3e-3
MADE_OF = {"coulomb_friction": 0.005, "tip_mass": 0.018}
OFFSETS = (0.01, -0.01)
SECONDS = "30"
LATE = 2e-3
"""A machine that lets a loop wait for longer (s) has the board answer late, and time is what is
measured here."""


def command(*arguments: str) -> None:
    done = CliRunner().invoke(cli, arguments, catch_exceptions=False, standalone_mode=False)
    assert done.exit_code == 0, done.output


def identified(folder: Path, payload: float | None) -> Identified | str:
    """What one paced run tells, or how it ended."""
    folder.mkdir()
    mechanics = Mechanics(
        payload=payload,
        hand=HeldForm(stiffness=0.0, damping=0.0),
        home_error=list(OFFSETS),
        **MADE_OF,
    )
    parameters = {"device": 1, "initial_tip_position": (0.019, 0.1)}
    order = Order(name="haply", priority=65, parameters=parameters, mechanics=mechanics)
    file, plan, run = (folder / each for each in ("haply.device.yaml", "plan.yaml", "run"))
    with Emulator(order) as emulator:
        save(file, {"driver": "haply", "preset": "haply", "home": list(emulator.home)})
        given = ["--url", emulator.url, "--seconds", SECONDS, "--payload", f"{payload or 0} kg"]
        command("identify", "--plan", str(file), *given, "--out", str(plan))
        output = ("--realtime", "--enable-output", "--yes", "--no-figure", "--no-report")
        arguments = ["run", str(plan), *output, "--out", str(run)]
        done = CliRunner().invoke(cli, arguments, standalone_mode=False)
    if done.exit_code != 0:
        return f"the run ended with {done.exit_code}: {done.output[-400:]}"
    return cohaptic.identify(run)


@pytest.mark.exhaustive
@pytest.mark.parametrize("payload", [None, 0.05], ids=["bare", "50 g"])
def test_a_paced_run_tells_inertia_friction_latency_and_offsets(tmp_path, payload) -> None:
    found = timed(lambda number: identified(tmp_path / f"attempt{number}", payload), tolerates=LATE)
    # The mass on the tip is known, and none of the device's.
    inertia = inertia_matrix(HAPLY, HOME) @ Nominal.of("haply", MADE_OF).values(HAPLY)[:5]
    print("\n" + "\n".join(str(each) for each in found.estimates))
    assert found["home_11"].value == pytest.approx(inertia[0, 0], rel=SHARE)
    assert found["home_22"].value == pytest.approx(inertia[1, 1], rel=SHARE)
    assert found["coulomb_1"].value == pytest.approx(0.005, rel=SHARE)
    assert found["coulomb_2"].value == pytest.approx(0.005, rel=SHARE)
    assert found["latency"].value * 1024 == pytest.approx(1.0, abs=LATENCY_TICKS)
    for number, offset in enumerate(OFFSETS, 1):
        assert found[f"offset_{number}"].value == pytest.approx(offset, abs=OFFSET)
