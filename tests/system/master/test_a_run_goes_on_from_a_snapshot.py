"""Saved at any tick and continued in a new process, beyond its first end, a run is the same run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.support.master.snapshots import continued, save, whole

SCENARIOS = Path(__file__).parents[3] / "scenarios"
BUNDLED = sorted((*SCENARIOS.glob("*.yaml"), *SCENARIOS.glob("thesis/*.yaml")))
FIRST_END, END = 1536, 1800
"""Ticks; contact is made after 1024."""
LOSSY = (
    'channels.lan.jitter="3 ticks"',
    "channels.lan.loss={good_to_bad: 0.1, bad_to_good: 0.3}",
    "channels.lan.reorder=0.1",
    "channels.lan.duplication=0.1",
)
TURNED = (
    'channels.lan.jitter="3 ticks"',
    "channels.lan.loss={good_to_bad: 0.1, bad_to_good: 0.3}",
    "knobs={vr_b.compensation.x: {}}",
    (
        "events=[{at: 500 ticks, set: {lan.round_trip_delay: 4, vr_a.coupling_stiffness: 40}},"
        " {at: 901 ticks, set: {lan.jitter: 0, vr_a.compensation.x: -2, vr_b.coupling_damping: 6}},"
        " {at: 1300 ticks, set: {lan.forward.delay: 0, vr_b.local_normal_stiffness: 1.2 N/mm}}]"
    ),
)
"""Knobs that are turned before, between and after the snapshots."""


def flavoured(path: Path, flavour: str) -> list[str]:
    """Every FMU of ours in another flavour."""
    components = yaml.safe_load(path.read_text())["components"]
    return [
        f"components.{name}.flavour={flavour}"
        for name, written in components.items()
        if "/" not in written.get("fmu", "/")
    ]


def goes_on(path: Path, sets: Sequence[str], folder: Path, seed: int) -> None:
    ticks = sorted(np.random.default_rng(seed).choice(FIRST_END + 1, 20, replace=False).tolist())
    files = save(path, sets, ticks, FIRST_END, folder)
    run = whole(path, sets, END)
    assert continued(path, sets, files, END) == [run.digest(tick) for tick in ticks]


@pytest.mark.parametrize(
    ("name", "sets"),
    [
        ("two_users_box", LOSSY),
        ("two_users_box", TURNED),
        ("single_axis_distributed", ()),
        ("thesis/grasp_deadband", ()),
    ],
)
def test_in_a_new_process(name: str, sets: tuple[str, ...], tmp_path: Path) -> None:
    goes_on(SCENARIOS / f"{name}.yaml", sets, tmp_path, 1)


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3-arrays"])
def test_in_every_flavour(flavour: str, tmp_path: Path) -> None:
    path = SCENARIOS / "single_axis_distributed.yaml"
    sets = flavoured(path, flavour)
    assert sets
    goes_on(path, sets, tmp_path, 2)


@pytest.mark.slow
@pytest.mark.parametrize("path", BUNDLED, ids=lambda path: path.stem)
def test_of_every_bundled_scenario(path: Path, tmp_path: Path) -> None:
    goes_on(path, (), tmp_path, 3)


@pytest.mark.slow
@pytest.mark.parametrize("flavour", ["fmi2", "fmi3-arrays"])
def test_of_the_box_in_every_flavour(flavour: str, tmp_path: Path) -> None:
    path = SCENARIOS / "two_users_box.yaml"
    goes_on(path, (*flavoured(path, flavour), *LOSSY), tmp_path, 4)
