"""A scenario is read as a loop of chapters 3 to 6 only where its run is that loop, to a wire."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from cosim.analysis.answers.asked import ask
from cosim.analysis.longest_delay import longest_delay
from cosim.analysis.loop import read_loop
from cosim.analysis.worlds import tell_of
from cosim.base.errors import InputError
from cosim.scenario import Connection, Scenario
from cosim.scenario.load import load, read
from cosim.sweep.theory import spectral_radius
from cosim.theory.models.parameters import Parameters
from cosim.theory.stability.spectral_radius import stability
from tests.support.theory.mutations import NAMES, mutations

WIRES = [(name, number) for name in NAMES for number in range(1, len(load(name).connections))]
"""All but the force of a user, which comes from outside of the loop."""


def joined(scenario: Scenario, connections: Sequence[Connection]) -> Scenario:
    return replace(scenario, connections=tuple(connections))


def changed(name: str, number: int, change: Callable[[Connection], list[Connection]]) -> Scenario:
    scenario = load(name)
    links = list(scenario.connections)
    return joined(scenario, [*links[:number], *change(links[number]), *links[number + 1 :]])


def closed_radius(scenario: Scenario) -> float:
    loop = read_loop(scenario)
    model = Parameters(loop.architecture, loop.values, {}, loop.users).model()
    return stability(model, loop.timing).spectral_radius


@pytest.mark.parametrize(("name", "number"), WIRES)
def test_every_wire_counts(name: str, number: int) -> None:
    read_loop(load(name))
    with pytest.raises(InputError):
        read_loop(changed(name, number, lambda _: []))
    with pytest.raises(InputError, match=r"has it once|no such connection|does not join"):
        read_loop(changed(name, number, lambda link: [link, link]))
    for other in ({"factor": 2.0}, {"factor": -1.0}, {"offset": 0.1}):
        with pytest.raises(InputError, match="factor or an offset"):
            read_loop(changed(name, number, lambda link, o=other: [replace(link, **o)]))


@pytest.mark.parametrize("name", NAMES)
def test_the_order_of_connections_and_components_does_not_count(name: str) -> None:
    scenario = load(name)
    turned = replace(
        joined(scenario, scenario.connections[::-1]),
        components=dict(reversed(scenario.components.items())),
    )
    loop = read_loop(turned)
    if loop.architecture == "distributed":  # users are numbered as they are written
        assert closed_radius(turned) == pytest.approx(closed_radius(scenario), rel=1e-12)
    else:
        assert loop == read_loop(scenario)


OTHERS: list[tuple[str, list[str], str]] = [
    ("single_user", ["connections.0=object.velocity -> hand_1.force"], "no such connection"),
    ("single_user", ["connections.2=hand_1.position -> coupler_1.velocity_a"], "no such|join"),
    ("single_user", ["connections.5=coupler_1.reaction -> object.force[1]"], "no such connection"),
    ("single_user", ["components.coupler_1.feedthrough=false"], "has 'feedthrough'"),
    ("single_user", ["components.coupler_1.substeps=2"], "has 'substeps'"),
    ("single_user", ["components.object.substeps=2"], "has 'substeps'"),
    (
        "single_user",
        [
            "knobs={coupler_1.stiffness: {minimum: 0, maximum: 5000}}",
            "connections.0=step_1.value -> coupler_1.stiffness",
        ],
        "no such connection",
    ),
    (
        "single_axis_centralized",
        [
            "components.hand_1.station=station_2",
            "connections.1=hand_1.position -> coupler_1.position_a via lan",
            "connections.2=hand_1.velocity -> coupler_1.velocity_a via lan",
            "connections.6=coupler_1.reaction -> hand_1.coupler_force via lan",
            "components.step_1.station=station_2",
        ],
        "user 1 alone is there",
    ),
    (
        "single_axis_distributed",
        ["connections.6=coupler_12.reaction -> hand_1.coupler_force"],
        "no such connection",
    ),
]


@pytest.mark.parametrize(("name", "sets", "said"), OTHERS, ids=[str(n) for n in range(len(OTHERS))])
def test_another_loop_is_refused(name: str, sets: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_loop(load(name, sets=sets))


def test_two_couplers_at_one_place_are_refused() -> None:
    """The second would be read in place of the first."""
    scenario = load("single_user")
    second = replace(scenario.components["coupler_1"], name="coupler_2")
    wires = [
        replace(
            link,
            source=replace(link.source, component="coupler_2")
            if link.source.component == "coupler_1"
            else link.source,
            target=replace(link.target, component="coupler_2")
            if link.target.component == "coupler_1"
            else replace(link.target, path=link.target.path.replace("[1]", "[2]")),
        )
        for link in scenario.connections
        if "coupler_1" in {link.source.component, link.target.component}
    ]
    twice = replace(
        joined(scenario, [*scenario.connections, *wires]),
        components={**scenario.components, "coupler_2": second},
    )
    with pytest.raises(InputError, match="coupler_1 and coupler_2 both join hand_1 and object"):
        read_loop(twice)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("batch", range(12))
def test_what_is_read_of_a_mutated_scenario_is_its_run(batch: int) -> None:
    """Up to three changes that the run answers for: the same radius, or refused, or said."""
    generator = np.random.default_rng(900 + batch)
    told = 0
    for number in range(10):
        name = NAMES[(batch + number) % 3]
        sets = mutations(generator, name)
        written = read(name, (), sets)
        try:
            loop = read_loop(written.built())
        except InputError:
            continue
        if any("is taken as" in note for note in loop.notes):
            continue
        told += 1
        with ask(written) as asked:
            found = asked.point().spectrum().radius
        assert closed_radius(written.built()) == pytest.approx(found, abs=1e-9), (name, sets)
    assert told > 0


PLANAR = "components.vr_a.parameters"
SERVER = "components.server.parameters"
TWIN = "two_users_box_centralized"
LEFT_OUT: list[tuple[str, list[str], str]] = [
    ("two_users_box", [f"{PLANAR}.predictor=linear"], "vr_a has prediction"),
    ("two_users_box", [f"{PLANAR}.environment=mass_spring"], "vr_a has a soft object"),
    ("two_users_box", [f"{PLANAR}.passivity=time_domain"], "vr_a has a passivity layer"),
    ("two_users_box", [f"{PLANAR}.deadband=0.1"], "vr_a has a deadband"),
    ("two_users_box", [f"{PLANAR}.wall_1.enabled=true"], "vr_a has a wall"),
    (
        "two_users_box",
        ["components.finger_a1.parameters.computation_delay_ticks=2"],
        "finger_a1 has a computation delay",
    ),
    (TWIN, [f"{SERVER}.force_channel=wave"], "server has waves"),
    (TWIN, ["components.client.parameters.passivity=time_domain"], "client has a passivity layer"),
    ("two_users_box", [f"{PLANAR}.peers=0"], "vr_a hears vr_b at peer_1, and has 0 peers"),
    ("two_users_box", [f"{PLANAR}.peers=2"], "has 2 peers"),
    (TWIN, [f"{SERVER}.peers=0"], "server hears client at client_1, and has 0 peers"),
    ("two_users_box", ["components.finger_a1.rate=512 Hz"], "finger_a1 steps 512 times"),
    ("two_users_box", ["components.vr_a.feedthrough=false"], "vr_a has 'feedthrough'"),
    ("two_users_box", ["components.finger_b2.substeps=2"], "finger_b2 has 'substeps'"),
    (
        "two_users_box",
        ["components.finger_a1.parameters.finger_mass=0.5"],
        "finger_a1 has a finger_mass of its own",
    ),
    (
        "two_users_box",
        ["components.vr_a.start.peer_weight=[0.5, 1, 1]"],
        "vr_a starts with a peer_weight",
    ),
]


@pytest.mark.parametrize(
    ("name", "sets", "said"), LEFT_OUT, ids=[sets[0].partition("=")[0] for _, sets, _ in LEFT_OUT]
)
def test_every_reader_of_a_planar_loop_refuses_what_it_leaves_out(
    name: str, sets: list[str], said: str
) -> None:
    scenario = load(name, sets=sets)
    with pytest.raises(InputError, match=said):
        read_loop(scenario)
    with pytest.raises(InputError, match=said):
        spectral_radius(scenario)
    assert longest_delay(scenario) is None
    assert said.split(maxsplit=1)[0] in tell_of(scenario)[0].refusal


def test_a_delay_between_samples_is_rounded_up_and_said() -> None:
    for name in ("two_users_box", TWIN):
        sets = ["channels.lan.round_trip_delay=~", "channels.lan.each_way_delay='7 ticks'"]
        loop = read_loop(load(name, sets=sets))
        assert (loop.timing.delay.forward, loop.timing.delay.backward) == (1, 1)
        assert "A delay of 7 ticks is taken as 1 samples." in loop.notes


def test_what_runs_draw_or_turn_is_no_point_of_a_sweeps_theory() -> None:
    for sets in (
        ["channels.lan.loss=0.2"],
        ["channels.lan.jitter=1"],
        ["channels.lan.round_trip_delay=~", "channels.lan.each_way_delay='7 ticks'"],
    ):
        for name in ("two_users_box", "single_axis_distributed"):
            with pytest.raises(InputError):
                spectral_radius(load(name, sets=sets))
    with pytest.raises(InputError, match="is turned at tick"):
        spectral_radius(load("single_axis_turned"))


def test_a_compensation_that_is_still_a_word_is_not_zero() -> None:
    auto = [f"components.vr_{which}.parameters.compensation=auto" for which in "ab"]
    with pytest.raises(InputError, match="has yet to compute"):
        read_loop(load("two_users_box", sets=auto))
