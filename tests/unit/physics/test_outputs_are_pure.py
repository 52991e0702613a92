"""Outputs follow from the committed state and the inputs now: asking changes nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.development import Instance
from fmus.layout import Placed

MODELS = ("pantograph", "distributed_workstation", "central_server", "remote_client")


def inputs(instance: Instance) -> list[Placed]:
    return [p for p in instance.layout.placed if p.variable.causality == "input"]


def outputs(instance: Instance) -> list[Placed]:
    return [p for p in instance.layout.placed if p.variable.causality == "output"]


def feed(instance: Instance, rng: np.random.Generator) -> None:
    """Random but plausible inputs."""
    for placed in inputs(instance):
        size, name, kind = placed.variable.size or 1, placed.path, placed.variable.type
        if kind == "boolean":
            values = rng.integers(0, 2, size)
        elif name.endswith("joint_angle"):
            values = np.array([2.28, 0.86]) + rng.normal(0, 0.05, 2)
        elif name.endswith("status"):
            values = rng.choice([11, 107, 15, 1], size, p=[0.4, 0.4, 0.1, 0.1])
        elif kind == "integer":
            values = rng.integers(0, 3, size)
        else:
            values = rng.normal(0, 0.03, size)
        instance[name] = values if placed.variable.size else values[0]


def read(instance: Instance) -> list[bytes]:
    return [np.asarray(instance[p.path]).tobytes() for p in outputs(instance)]


@pytest.mark.parametrize("model", MODELS)
@settings(deadline=None, max_examples=15)
@given(seed=st.integers(0, 2**32 - 1))
def test_asking_twice_gives_the_same_bits_and_changes_no_state(model: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    instance = Instance(model)
    if model != "pantograph":
        instance.set({"initial_box_pose.y": 0.12} if model != "remote_client" else {})
    instance.initialise()
    for _ in range(12):
        feed(instance, rng)
        before = instance._state.tobytes()
        first = read(instance)
        kept = instance.state
        assert read(instance) == first
        assert instance._state.tobytes() == before
        feed(instance, rng)
        read(instance)
        instance.state = kept
        assert read(instance) == first
        instance.step()


@pytest.mark.parametrize("model", MODELS)
def test_a_restored_state_repeats_the_run(model: str) -> None:
    instance = Instance(model)
    instance.initialise()

    def run() -> list[list[bytes]]:
        rng, seen = np.random.default_rng(3), []
        for _ in range(30):
            feed(instance, rng)
            seen.append(read(instance))
            instance.step()
        return seen

    run()
    kept, time = instance.state, instance.time
    first = run()
    instance.state, instance.time = kept, time
    assert run() == first


@pytest.mark.parametrize(
    ("model", "options"),
    [
        *((model, {}) for model in MODELS),
        ("central_server", {"force_channel": 1}),
        ("remote_client", {"force_channel": 1}),
        ("distributed_workstation", {"deadband": 0.1, "passivity": 1, "network_ticks": 2}),
        ("central_server", {"environment": 1, "deadband": 0.1, "network_ticks": 1}),
    ],
    ids=str,
)
def test_dependencies_name_every_input_that_reaches_an_output(
    model: str, options: dict[str, float]
) -> None:
    """Change one input at a time: only outputs that declare it may change."""
    rng = np.random.default_rng(11)
    instance = Instance(model, **options)
    if model in {"distributed_workstation", "central_server"}:
        instance.set(
            {"initial_box_pose.x": 0.04, "initial_box_pose.y": 0.2, "predictor": 1, "peers": 3}
        )
    instance.initialise()
    for _ in range(10):
        feed(instance, rng)
        base = {p.path: np.asarray(instance[p.path]).tobytes() for p in outputs(instance)}
        kept = instance.state
        for changed in inputs(instance):
            feed_one = np.random.default_rng(rng.integers(1 << 30))
            current = np.asarray(instance[changed.path])
            feed(instance, feed_one)
            new = instance[changed.path]
            instance.state = kept
            instance[changed.path] = new if not np.array_equal(new, current) else current + 1
            for placed in outputs(instance):
                if np.asarray(instance[placed.path]).tobytes() == base[placed.path]:
                    continue
                declared = instance.layout.matching(placed.variable.depends_on, placed.group)
                assert changed.path in {p.path for p in declared}, (placed.path, changed.path)
            instance.state = kept
        instance.step()


@pytest.mark.parametrize("model", MODELS[1:])
def test_another_period_than_the_models_own_is_refused(model: str) -> None:
    instance = Instance(model)
    instance.initialise()
    with pytest.raises(Exception, match="sample_period"):
        instance.step(1 / 512)
