"""The single-axis models, signals and the emulated user against what their equations say."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from fmus.development import Instance, ModelError

STEP = 1 / 1024
FORCE = st.floats(-20, 20)


def exact_step(state: np.ndarray, force: float, mass: float, h: float) -> np.ndarray:
    """Zero-order hold by the matrix exponential of the augmented system (eq. 3.14 to 3.16)."""
    system = np.zeros((3, 3))
    system[0, 1], system[1, 2] = 1.0, 1.0 / mass
    return (expm(system * h) @ np.append(state, force))[:2]


@settings(deadline=None, max_examples=30)
@given(
    forces=st.lists(st.tuples(FORCE, FORCE), min_size=1, max_size=10),
    mass=st.floats(0.01, 5),
    start=st.tuples(st.floats(-1, 1), st.floats(-1, 1)),
    h=st.sampled_from([STEP, 1 / 128, 0.1]),
)
def test_hand_is_a_mass_under_held_forces(
    forces: list[tuple[float, float]], mass: float, start: tuple[float, float], h: float
) -> None:
    hand = Instance("hand", mass=mass, initial_position=start[0], initial_velocity=start[1])
    hand.initialise()
    state = np.array(start)
    for own, coupler in forces:
        hand.set({"force": own, "coupler_force": coupler})
        hand.step(h)
        state = exact_step(state, own + coupler, mass, h)
    assert [hand["position"], hand["velocity"]] == pytest.approx(state, rel=1e-12, abs=1e-12)


@settings(deadline=None, max_examples=30)
@given(
    forces=st.lists(st.tuples(FORCE, FORCE, FORCE, FORCE), min_size=1, max_size=10),
    compensation=st.floats(-5, 5),
    wall=st.sampled_from([(0.0, 0.0, 0.0), (30000.0, 20.0, 0.01)]),
)
def test_object_samples_and_holds_its_own_forces(
    forces: list[tuple[float, ...]], compensation: float, wall: tuple[float, float, float]
) -> None:
    stiffness, damping, place = wall
    body = Instance(
        "object",
        compensation=compensation,
        wall_stiffness=stiffness,
        wall_damping=damping,
        wall_position=place,
        initial_velocity=0.3,
    )
    body.initialise()
    x = np.array([0.0, 0.3])
    for force in forces:
        total = sum(force) - compensation * x[1] - stiffness * (x[0] - place) - damping * x[1]
        body["force"] = (*force, *(0.0,) * 13)
        body.step()
        x = exact_step(x, total, 0.4, STEP)
    assert [body["position"], body["velocity"]] == pytest.approx(x, rel=1e-11, abs=1e-12)


@given(
    a=st.tuples(FORCE, FORCE),
    b=st.tuples(FORCE, FORCE),
    k=st.floats(0, 1e5),
    damping=st.floats(0, 100),
)
@settings(deadline=None, max_examples=30)
def test_coupler_is_a_spring_and_a_damper(
    a: tuple[float, float], b: tuple[float, float], k: float, damping: float
) -> None:
    coupler = Instance("virtual_coupler", stiffness=k, damping=damping)
    coupler.initialise()
    names = ("position_a", "velocity_a", "position_b", "velocity_b")
    coupler.set(dict(zip(names, (*a, *b), strict=True)))
    expected = k * (a[0] - b[0]) + damping * (a[1] - b[1])
    assert coupler["force"] == pytest.approx(expected, rel=1e-12, abs=1e-9)
    assert coupler["reaction"] == -coupler["force"]


@pytest.mark.parametrize("delay", range(9))
def test_computation_delay_is_whole_steps(delay: int) -> None:
    coupler = Instance("virtual_coupler", stiffness=1.0, damping=0.0)
    coupler.initialise(computation_delay_ticks=delay)
    seen = []
    for tick in range(20):
        coupler["position_a"] = tick + 1.0
        seen.append(coupler["force"])
        coupler.step()
    assert seen == [max(0, tick + 1 - delay) for tick in range(20)]


def run(signal: Instance, ticks: int, h: float = STEP) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rows = []
    for _ in range(ticks):
        rows.append((signal.time, signal["value"], signal["rate"]))
        signal.step(h)
    time, value, rate = np.array(rows).T
    return time, value, rate


def test_constant_and_step() -> None:
    signal = Instance("signal", amplitude=2.0, offset=1.0)
    signal.initialise()
    assert np.all(run(signal, 5)[1] == 3.0)
    signal.initialise(mode=1, start_time=3 * STEP, duration=2 * STEP)
    assert run(signal, 8)[1].tolist() == [1, 1, 1, 3, 3, 1, 1, 1]


@pytest.mark.parametrize("rectify", [False, True])
def test_sine(rectify: bool) -> None:
    signal = Instance("signal", mode=2, amplitude=1.5, frequency=30.0, phase=0.4, rectify=rectify)
    signal.initialise(offset=0.25)
    time, value, rate = run(signal, 500)
    wave = 1.5 * np.sin(30.0 * time + 0.4)
    expected = 0.25 + (np.maximum(wave, 0) if rectify else wave)
    assert value == pytest.approx(expected, abs=1e-14)
    slope = 45.0 * np.cos(30.0 * time + 0.4) * (wave > 0 if rectify else 1)
    assert rate == pytest.approx(slope, abs=1e-12)


def test_signals_follow_the_start_time_of_the_simulation() -> None:
    signal = Instance("signal", mode=2, frequency=2.0)
    signal.initialise(7.0)
    time, value, _ = run(signal, 10)
    assert time[0] == 7.0
    assert value == pytest.approx(np.sin(2.0 * time), abs=1e-14)


def test_minimum_jerk_minimises_jerk() -> None:
    """Its sixth derivative vanishes: it equals the solution of that boundary value problem."""
    signal = Instance("signal", mode=3, amplitude=0.3, offset=-0.1, start_time=0.1, duration=0.5)
    signal.initialise()
    time, value, rate = run(signal, 800)
    assert np.all(value[time <= 0.1] == -0.1)
    assert value[time >= 0.6] == pytest.approx(0.2, abs=1e-15)
    # x''' at the start, x'''' and x''''' follow from 10u³ − 15u⁴ + 6u⁵ being the unique quintic.
    ends = np.array([[1, 1, 1], [3, 4, 5], [6, 12, 20]], float)
    third, fourth, fifth = np.linalg.solve(ends, [1.0, 0.0, 0.0])
    start = [0, 0, 0, 6 * third, 24 * fourth, 120 * fifth]
    inside = (time > 0.1) & (time < 0.6)
    u = (time[inside] - 0.1) / 0.5
    solution = solve_ivp(
        lambda _, y: [*y[1:], 0.0], (0, 1), start, t_eval=u, rtol=1e-12, atol=1e-14
    )
    assert value[inside] == pytest.approx(-0.1 + 0.3 * solution.y[0], abs=1e-10)
    assert rate[inside] == pytest.approx(0.3 * solution.y[1] / 0.5, abs=1e-9)


def test_minimum_jerk_needs_a_duration() -> None:
    with pytest.raises(ModelError, match="duration is 0 s"):
        Instance("signal").initialise(mode=3)


@pytest.mark.parametrize("linear", [True, False])
def test_table(tmp_path: Path, linear: bool) -> None:
    random = np.random.default_rng(3)
    times = np.cumsum(random.uniform(0.001, 0.02, 40))
    values = random.normal(size=40)
    path = tmp_path / "with a space.csv"
    np.savetxt(path, np.c_[times, values], fmt="%.17g", delimiter=",", header="t,value")
    signal = Instance("signal", mode=4, table_file=str(path), interpolate=linear, amplitude=2.0)
    signal.initialise(start_time=0.05)
    time, value, rate = run(signal, 600)
    at = time - 0.05
    held = values[np.maximum(np.searchsorted(times, at, side="right") - 1, 0)]
    expected = np.interp(at, times, values) if linear else held
    assert value == pytest.approx(2 * expected, abs=1e-12)
    if not linear:
        assert np.all(rate == 0)


@pytest.mark.parametrize(
    ("text", "words"),
    [("0,1\n0,2\n", "times must rise"), ("1\n", "2 are needed"), (None, "cannot be opened")],
)
def test_bad_tables_are_refused(tmp_path: Path, text: str | None, words: str) -> None:
    path = tmp_path / "table.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(ModelError, match=words):
        Instance("signal").initialise(mode=4, table_file=str(path))
    with pytest.raises(ModelError, match="table_file is empty"):
        Instance("signal").initialise(mode=4)


@pytest.mark.parametrize("first", ["0,nan", "nan,nan", "NaN;1", "0,-Infinity", "x,1", "inf\t2"])
def test_a_row_that_is_no_number_is_no_heading(tmp_path: Path, first: str) -> None:
    path = tmp_path / "table.csv"
    path.write_text(f"{first}\n1,2\n")
    with pytest.raises(ModelError, match=r"line 1: .* is not a list of finite numbers"):
        Instance("signal").initialise(mode=4, table_file=str(path))


@pytest.mark.parametrize("heading", ["t,value", "time [s];x [m]", "nanometres information", "#1,2"])
def test_a_heading_names_columns(tmp_path: Path, heading: str) -> None:
    path = tmp_path / "table.csv"
    path.write_text(f"{heading}\n0,3\n1,3\n")
    signal = Instance("signal", mode=4, table_file=str(path), amplitude=1.0)
    signal.initialise()
    assert run(signal, 3)[1] == pytest.approx(3.0)


PRESETS = {1: (100.0, 3.0), 2: (300.0, 8.0), 3: (800.0, 15.0)}


@settings(deadline=None, max_examples=30)
@given(
    preset=st.sampled_from([0, 1, 2, 3]),
    position=st.tuples(FORCE, FORCE),
    velocity=st.tuples(FORCE, FORCE),
    goal=st.tuples(FORCE, FORCE),
)
def test_operator_pulls_towards_its_reference(
    preset: int, position: tuple[float, ...], velocity: tuple[float, ...], goal: tuple[float, ...]
) -> None:
    user = Instance("operator", impedance=preset, stiffness=5.0, damping=2.0)
    user.initialise(initial_position=goal)
    user.set({"position": position, "velocity": velocity})
    k, b = PRESETS.get(preset, (5.0, 2.0))
    expected = k * (np.array(goal) - position) - b * np.array(velocity)
    assert user["force"] == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_operator_sine_reference_and_its_velocity() -> None:
    user = Instance("operator", trajectory=1, initial_position=[0.1, 0.2], impedance=0)
    user.initialise(
        sine_amplitude=[0.0, 0.05], sine_frequency=[1.0, 2.0], trajectory_start_time=0.01
    )
    for _ in range(200):
        late = max(user.time - 0.01, 0.0)
        assert user["reference_position"] == pytest.approx(
            [0.1, 0.2 + 0.05 * math.sin(2 * late)], abs=1e-14
        )
        moving = user.time >= 0.01
        assert user["reference_velocity"] == pytest.approx(
            [0.0, 0.1 * math.cos(2 * late) * moving], abs=1e-14
        )
        user.step()


def test_operator_visits_its_via_points_and_rests_there() -> None:
    times, points = [0.25, 0.5, 1.0], [[0.1, 0.0], [0.1, 0.0], [-0.2, 0.3]]
    pad = [0.0] * 13
    user = Instance("operator", trajectory=2, via_count=3, via_time=[*times, *pad])
    user.initialise(
        via_x=[*(p[0] for p in points), *pad],
        via_y=[*(p[1] for p in points), *pad],
        initial_position=[0.0, 0.1],
    )
    track = []
    for _ in range(1100):
        track.append((*user["reference_position"], *user["reference_velocity"]))
        user.step()
    track = np.array(track)
    for time, point in zip(times, points, strict=True):
        assert track[int(time * 1024)] == pytest.approx([*point, 0, 0], abs=1e-15)
    assert np.all(track[256:513, 2:] == 0)  # waits where a point is repeated
    assert track[-1] == pytest.approx([-0.2, 0.3, 0, 0], abs=1e-15)
    difference = np.gradient(track[:, :2], STEP, axis=0)
    assert difference == pytest.approx(track[:, 2:], abs=2e-4)


def test_operator_refuses_via_points_out_of_order() -> None:
    with pytest.raises(ModelError, match=r"via_time\[2\] is 0\.5 s, not after 0\.5 s"):
        Instance("operator").initialise(trajectory=2, via_count=2, via_time=[0.5, 0.5, *[0.0] * 14])
    with pytest.raises(ModelError, match="via_count is 0"):
        Instance("operator").initialise(trajectory=2)


def test_operator_follows_a_recording(tmp_path: Path) -> None:
    path = tmp_path / "hand.csv"
    path.write_text("t,x,y\n0,0,1\n0.5,1,3\n1,1,0\n")
    user = Instance("operator", trajectory=3, trajectory_file=str(path))
    user.initialise(trajectory_start_time=0.125)
    for _ in range(1200):
        at = user.time - 0.125
        expected = [np.interp(at, [0, 0.5, 1], y) for y in ([0, 1, 1], [1, 3, 0])]
        assert user["reference_position"] == pytest.approx(expected, abs=1e-14)
        user.step()


def test_operator_commands_a_force_on_each_axis() -> None:
    user = Instance("operator", impedance=0, force_mode=[1, 3], force_amplitude=[-2.0, 1.5])
    user.initialise(force_frequency=[0.0, 3.0], force_rectify=[False, True])
    for _ in range(1500):
        wave = max(1.5 * math.sin(3 * user.time), 0.0)
        assert user["force"] == pytest.approx([-2.0, wave], abs=1e-14)
        user.step()
    user.initialise(force_mode=[2, 0], force_start_time=[0.5, 0.0], force_duration=[0.25, 0.0])
    seen = []
    for _ in range(1024):
        seen.append(user["force"][0])
        user.step()
    assert np.flatnonzero(seen).tolist() == list(range(512, 768))


def test_operator_given_its_reference_follows_it() -> None:
    """The point itself within the tick; its velocity from the second step on."""
    user = Instance("operator", trajectory=5, impedance=0, stiffness=[100.0, 0.0], damping=[0, 2.0])
    user.initialise()
    point = [0.0, 0.0]
    for k in range(20):
        before, point = point, [0.01 * k**2, -0.02 * k]
        user["target_position"] = point
        rate = [(b - a) * 1024.0 if k else 0.0 for a, b in zip(before, point, strict=True)]
        assert user["reference_position"].tolist() == point
        assert user["reference_velocity"] == pytest.approx(rate, abs=1e-12)
        assert user["force"] == pytest.approx([100.0 * point[0], 2.0 * rate[1]], abs=1e-10)
        user.step()
