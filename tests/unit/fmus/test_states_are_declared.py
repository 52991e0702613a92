"""What changes in a model's State is declared, where it is declared, and nothing else changes."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.analysis.monodromy.declared import DeclaredState
from cosim.master.run.simulation import assemble
from cosim.scenario.load import read
from fmus.builder import load_model
from fmus.names import model_names

SCENARIOS = (
    ("two_users_box", ()),
    ("two_users_box", ("components.vr_a.parameters.environment=mass_spring",)),
    ("thesis/grasp_centralized_wave", ()),
    ("thesis/wall_push_distributed", ()),
    ("single_axis_distributed", ("components.coupler_11.parameters.computation_delay_ticks=3",)),
    ("two_users_box", ("components.finger_a1.parameters.computation_delay_ticks=3",)),
)


def test_every_model_declares_its_state() -> None:
    assert [name for name in model_names() if not load_model(name).state] == []


@pytest.mark.parametrize(("name", "sets"), SCENARIOS)
def test_what_is_not_declared_never_changes(name: str, sets: tuple[str, ...]) -> None:
    with assemble(read(name, (), sets).built()) as simulation:
        simulation.start()
        simulation.advance(64)
        before = words(simulation)
        seen = {component: np.zeros(found.size, dtype=bool) for component, found in before.items()}
        for tick in range(200, simulation.scenario.ticks, 199):
            simulation.advance(tick)
            for component, found in words(simulation).items():
                seen[component] |= found != before[component]
        for component, changed in seen.items():
            declared = DeclaredState(simulation.fmus[component].description, before[component])
            changed[declared.changing] = False
            assert not changed[declared.first :].any(), component


def words(simulation: object) -> dict[str, np.ndarray]:
    fmus = simulation.fmus  # type: ignore[attr-defined]
    return {name: np.frombuffer(fmu.states.save(), np.int64) for name, fmu in fmus.items()}


def test_numbers_lie_where_the_compiler_put_them() -> None:
    """Seen by what they hold: positions at the start, the newest sample, the box's pose."""
    sets = ("components.vr_a.parameters.initial_box_pose.x=0.012",)
    with assemble(read("two_users_box", (), sets).built()) as simulation:
        simulation.start()
        simulation.advance(40)
        fmu = simulation.fmus["vr_a"]
        found = np.frombuffer(fmu.states.save(), np.int64)
        declared = DeclaredState(fmu.description, found)
        live = [one.path for one in declared.live]
        values = found.view(np.float64)[declared.places(found)]
        pose = declared.value(found, "box_pose.x")
        assert values[live.index("environment.box.pose.x")] == pose != 0.0
        newest = values[live.index("own.finger[0].samples.value of age 1[0]")]
        finger = simulation.fmus["finger_a1"]
        state = np.frombuffer(finger.states.save(), np.int64)
        angle = DeclaredState(finger.description, state).value(state, "joint_angle[1]")
        assert newest == pytest.approx(angle, abs=1e-3)
