"""Overlays, ``--set`` and includes: what each does, and the algebra between them."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.document.node import Node
from cosim.base.errors import InputError, Location
from cosim.scenario import Kind, Scenario
from cosim.scenario.impairments.loss import Bernoulli
from cosim.scenario.impairments.trace import Trace
from cosim.scenario.source.merge import merge, normalise
from cosim.scenario.source.override import apply_override

Load = Callable[..., Scenario]


def node(document: Any) -> Node:
    """The tree of plain data, as if it stood in a file."""

    def tree(value: Any) -> Node:
        if isinstance(value, dict):
            value = {key: tree(member) for key, member in value.items()}
        elif isinstance(value, list):
            value = [tree(item) for item in value]
        return Node(value, Location("d.yaml", 1, 1))

    return normalise(tree(document))


NAMES = st.sampled_from(["alpha", "beta", "gamma"])
SCALARS = st.integers(-5, 5) | st.sampled_from(["x", "y"]) | st.booleans()
TREES = st.recursive(
    SCALARS | st.lists(SCALARS, max_size=2),
    lambda inner: st.dictionaries(NAMES, inner, max_size=3),
    max_leaves=8,
)
# Sections without rules of their own: there the algebra is the plain one.
DOCUMENTS = st.dictionaries(
    st.sampled_from(["safety", "link", "realtime"]), st.dictionaries(NAMES, TREES, max_size=3)
)
# What is a mapping in one document is one in all; a value over a mapping forgets what was under it.
ALIKE = st.recursive(
    st.dictionaries(NAMES, SCALARS | st.lists(SCALARS, max_size=2), max_size=3),
    lambda inner: st.builds(
        lambda values, groups: values | groups,
        st.dictionaries(NAMES, SCALARS, max_size=2),
        st.dictionaries(st.sampled_from(["inner", "outer"]), inner, max_size=2),
    ),
    max_leaves=4,
)
ALIKE_DOCUMENTS = st.dictionaries(
    st.sampled_from(["safety", "link", "realtime"]), ALIKE, max_size=3
)


@settings(deadline=None, max_examples=60)
@given(DOCUMENTS)
def test_a_document_over_itself_or_over_nothing_is_itself(document: dict[str, Any]) -> None:
    assert merge(node(document), node(document)).plain() == document
    assert merge(node(document), node({})).plain() == document
    assert merge(node({}), node(document)).plain() == document


@settings(deadline=None, max_examples=60)
@given(DOCUMENTS, DOCUMENTS)
def test_what_lies_over_is_found_again(base: dict[str, Any], over: dict[str, Any]) -> None:
    merged = merge(node(base), node(over)).plain()

    def agrees(part: Any, whole: Any) -> bool:
        if isinstance(part, dict):
            return isinstance(whole, dict) and all(
                key in whole and agrees(value, whole[key]) for key, value in part.items()
            )
        return part == whole

    assert agrees(over, merged)
    assert set(merged) == set(base) | set(over)
    # A second time changes nothing.
    assert merge(node(merged), node(over)).plain() == merged


@settings(deadline=None, max_examples=60)
@given(ALIKE_DOCUMENTS, ALIKE_DOCUMENTS, ALIKE_DOCUMENTS)
def test_mappings_merge_associatively(a: Any, b: Any, c: Any) -> None:
    left = merge(merge(node(a), node(b)), node(c)).plain()
    right = merge(node(a), merge(node(b), node(c))).plain()
    assert left == right


@settings(deadline=None, max_examples=60)
@given(DOCUMENTS, st.lists(NAMES, min_size=1, max_size=3), SCALARS | st.lists(SCALARS, max_size=2))
def test_an_override_is_an_overlay_with_one_value(
    document: dict[str, Any], path: list[str], value: Any
) -> None:
    overlay: Any = value
    for key in reversed(["safety", *path]):
        overlay = {key: overlay}
    text = f"safety.{'.'.join(path)}={json.dumps(value)}"
    inner: Any = document.get("safety", {})
    for key in path[:-1]:
        inner = inner.get(key, {}) if isinstance(inner, dict) else inner
    if not isinstance(inner, dict):
        with pytest.raises(InputError):
            apply_override(node(document), text)
        return
    overridden = apply_override(node(document), text).plain()
    assert overridden == merge(node(document), node(overlay)).plain()
    # Idempotent, and the last one wins.
    assert apply_override(node(overridden), text).plain() == overridden


def test_a_change_of_kind_drops_what_belonged_to_the_old_kind(
    small: str, scenario_of: Load
) -> None:
    overlay = "components: {left: {device: {url: 'mock://', latency: 1}}}"
    left = scenario_of(small, overlay).components["left"]
    assert (left.kind, left.source) == (Kind.DEVICE, "mock://")
    assert left.options == {"latency": 1}
    assert left.parameters == {}
    assert (left.station, left.rate) == ("a", 1024)
    # The same kind keeps them; the override form does the same as the overlay.
    assert scenario_of(small, "components: {left: {fmu: operator}}").components[
        "left"
    ].parameters == {"base_x": 0.1}
    by_set = scenario_of(small, sets=("components.left.device=mock://",)).components["left"]
    assert by_set.kind is Kind.DEVICE
    assert by_set.parameters == {}


def test_what_is_removed_takes_its_connections_along(small: str, scenario_of: Load) -> None:
    scenario = scenario_of(small, "components: {third: ~}")
    assert [str(c) for c in scenario.connections] == [
        "left.joint_angle -> right.motor_torque via lan"
    ]
    scenario = scenario_of(small, "components: {left: ~}\nchannels: {lan: ~}")
    assert [str(c) for c in scenario.connections] == ["right.joint_angle -> third.motor_torque"]
    assert scenario.record == ()
    assert scenario.expect == {}
    with pytest.raises(InputError) as caught:
        scenario_of(small, "components: {lfet: ~}")
    assert str(caught.value) == (
        "o1.yaml:1:14: there is no component 'lfet' to remove. Did you mean left?"
    )


def test_what_is_removed_takes_what_turns_it_along(small: str, scenario_of: Load) -> None:
    turned = (
        "knobs: {third.mass: {}, lan.delay: {maximum: 4}}\n"
        "events:\n  - {at: 1, set: {third.mass: 1, lan.loss: 0.1}}\n"
        "  - {at: 1.5, set: {lan.loss: 0}}\n"
    )
    rest = scenario_of(small, turned, "components: {third: ~}")
    assert [str(knob.target) for knob in rest.knobs] == ["lan.forward.delay", "lan.backward.delay"]
    assert {str(event.target) for event in rest.events} == {"lan.forward.loss", "lan.backward.loss"}
    lan = scenario_of(small, turned, "channels: {lan: ~}")
    assert [str(knob.target) for knob in lan.knobs] == ["third.mass"]
    assert [(event.tick, str(event.target)) for event in lan.events] == [(1024, "third.mass")]


def test_connections_are_added_replaced_and_removed(small: str, scenario_of: Load) -> None:
    overlay = """
connections:
  - left.energy -> right.hand_force[1] via lan
  - right.true_joint_angle -> third.motor_torque
"""
    assert [str(c) for c in scenario_of(small, overlay).connections] == [
        "left.joint_angle -> right.motor_torque via lan",
        "right.true_joint_angle -> third.motor_torque",
        "left.energy -> right.hand_force[1] via lan",
    ]
    removed = scenario_of(small, "connections: [{remove: third.motor_torque}]")
    assert len(removed.connections) == 1
    with pytest.raises(InputError, match=r"no connection into 'third.torque' to remove\. Did you"):
        scenario_of(small, "connections: [{remove: third.torque}]")


def test_a_new_form_of_delay_replaces_the_old_one(small: str, scenario_of: Load) -> None:
    for override, (forward, backward) in {
        "channels.lan.round_trip_delay=3": (2, 1),
        "channels.lan.each_way_delay=2": (2, 2),
        "channels.lan.delay={forward: 0, backward: 5}": (0, 5),
    }.items():
        lan = scenario_of(small, sets=(override,)).channels["lan"]
        assert (lan.forward.delay.samples, lan.backward.delay.samples) == (forward, backward)
    lan = scenario_of(
        small, sets=("channels.lan.delay={forward: 1, backward: 2}", "channels.lan.delay.forward=4")
    ).channels["lan"]
    assert (lan.forward.delay.samples, lan.backward.delay.samples) == (4, 2)
    traced = scenario_of(small, sets=("channels.lan.trace=[1, lost]",)).channels["lan"]
    assert traced.forward.impairments == {"trace": Trace((8, -1))}
    assert traced.forward.delay.ticks == 0


def test_overrides_reach_everything(small: str, scenario_of: Load) -> None:
    scenario = scenario_of(
        small,
        sets=(
            "duration=500 ms",
            "components.left.parameters.finger.1.mass=20 g",
            "components.left.parameters.base_x=0.2",
            "connections.1.delay=2 ticks",
            "expect.left.energy.max_below=3",
            "record=[right.*, left.energy]",
        ),
    )
    assert scenario.duration == Fraction(1, 2)
    assert scenario.components["left"].parameters == {"base_x": 0.2, "finger.1.mass": "20 g"}
    assert scenario.connections[1].delay.ticks == 2
    assert scenario.expect == {"left.energy": {"max_below": 3}}
    assert [record.pattern for record in scenario.record] == ["right.*", "left.energy"]


MISTAKEN = {
    "seed": "write --set path.to.key=value.",
    "=3": "write --set path.to.key=value.",
    "seed=": "there is no value behind '='; '~' removes.",
    "seed=[": "the '[' that opens here is never closed; ']' is missing.",
    "components.lfet.rate=5": "there is no component 'lfet'. Did you mean left?",
    "rates.contrl=512": "there is no rate 'contrl'. Did you mean control?",
    "channels.wan.loss=0.1": "there is no channel 'wan'. Did you mean lan?",
    "connections.2.delay=1": "'connections' is a list with items 0 to 1; there is no '2'.",
    "title.x=1": "'title' is a single value; nothing is inside it.",
    "a..b=1": "'a..b' has an empty part; write path.to.key.",
    "sead=1": "unknown key 'sead'. Did you mean seed?",
    "components.left.staton=b": "unknown key 'staton' in components.left. Did you mean station?",
    "duration=3 kg": "duration: '3 kg' is in kg, which does not convert to s. Write a time, such "
    "as 10, '2.44 ms' or '2 min'.",
}


@pytest.mark.parametrize("override", MISTAKEN)
def test_a_mistaken_override_is_named(override: str, small: str, scenario_of: Load) -> None:
    with pytest.raises(InputError) as caught:
        scenario_of(small, sets=(override,))
    assert str(caught.value) == f"--set {override}: {MISTAKEN[override]}"
    assert caught.value.location == Location(f"--set {override}", 0, 0)


def test_fragments_lie_under_the_mapping_that_names_them(
    scenario_of: Load, small: str, tmp_path: Path
) -> None:
    parts = tmp_path / "parts"
    parts.mkdir()
    (parts / "lan.yaml").write_text("include: slow.yaml\nloss: 0.1\njitter: 1\n", "utf-8")
    (parts / "slow.yaml").write_text("loss: 0.5\nround_trip_delay: 4\n", "utf-8")
    (parts / "device.yaml").write_text("base_x: 7\nfinger: {x: 1}\n", "utf-8")
    (parts / "more.yaml").write_text(
        "cohaptic: 1\ntitle: not this one\nseed: 5\n"
        "components: {fourth: {fmu: operator, station: b, rate: network}}\n",
        "utf-8",
    )
    text = small.replace("round_trip_delay: 1", "include: parts/lan.yaml, jitter: 0")
    text = text.replace("{base_x: 0.1}", "{include: parts/device.yaml, finger.x: 2}")
    text = text.replace("rates:", "include: [parts/more.yaml]\nrates:")
    scenario = scenario_of(text)
    lan = scenario.channels["lan"]
    assert lan.forward.impairments == {"loss": Bernoulli(probability=0.1)}
    assert lan.forward.delay.samples == 2
    assert scenario.components["left"].parameters == {"base_x": 7, "finger.x": 2}
    assert (scenario.title, scenario.seed) == ("Two devices and a network", 5)
    assert scenario.components["fourth"].period == 8
    assert str(scenario.locate(("channels", "lan", "loss"))) == "parts/lan.yaml:2:7"
    preset = scenario_of(small, sets=("channels.lan={include: lan_2006}",)).channels["lan"]
    assert (preset.forward.delay.ticks, preset.backward.delay.ticks) == (2, 1)


def test_fragments_that_include_each_other_are_refused(
    scenario_of: Load, small: str, tmp_path: Path
) -> None:
    (tmp_path / "a.yaml").write_text("include: b.yaml", "utf-8")
    (tmp_path / "b.yaml").write_text("include: a.yaml", "utf-8")
    with pytest.raises(InputError) as caught:
        scenario_of(small.replace("title:", "include: a.yaml\ntitle:"))
    assert str(caught.value) == (
        "b.yaml:1:10: files include each other: s.yaml -> a.yaml -> b.yaml -> a.yaml."
    )


def test_anchors_and_merge_keys_work(scenario_of: Load, small: str) -> None:
    text = small.replace("rates:", "x-p: &p {a: 1, b: 2}\nrates:").replace(
        "{base_x: 0.1}", "{<<: *p, b: 3}"
    )
    assert scenario_of(text).components["left"].parameters == {"a": 1, "b": 3}
