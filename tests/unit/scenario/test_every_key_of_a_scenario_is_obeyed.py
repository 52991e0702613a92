"""Changing any key of a scenario changes its plan, its run or its output; nothing is for show.

The keys are taken from the forms: one without a case here fails the first test.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import CohapticError
from cosim.link.stream.form import read_link
from cosim.master.assembly.assemble import put_together
from cosim.reading import FORMS
from cosim.record import open_run
from cosim.record.digest import digest
from cosim.record.playback import KINDS
from cosim.report.window import MEASURES
from cosim.run import run_scenario
from cosim.scenario import load
from cosim.scenario.form.document import document_form
from cosim.scenario.form.sections import all_of
from cosim.station.split import split
from tests.support.forms import scenario_cases
from tests.support.forms.link_cases import LINK_CASES, what_two_stations_do
from tests.support.forms.scenario_cases import CASES, PARTS, document
from tests.support.forms.walk import keys_of

FORM = document_form(all_of(FORMS))
KEYS = keys_of(FORM)
ELSEWHERE = {
    # What devices make of their limits is shown with the devices.
    *(key for key in KEYS if key[0] == "SafetyForm"),
    *(key for key in KEYS if key[0] in {"LinkForm", "RealtimeForm"}),
    *(key for key in KEYS if key[0] in {"ExpectForm", "WindowForm"}),
    ("Document", "safety"),
    ("Document", "link"),
    ("ChannelForm", "link"),
    ("Document", "realtime"),
    ("ComponentForm", "playback"),
    ("ComponentForm", "of"),
    # Each key of a table is shown with the tables.
    *(("ComponentForm", key) for key in ("table", "columns", "interpolate", "time_offset")),
    # What an imperfect description meets is shown with such FMUs.
    ("ComponentForm", "validate"),
    # Units that differ are shown with FMUs that bring them.
    ("ConnectionForm", "unit"),
    # A process of its own has no effect on values, which is shown with the isolation.
    ("ComponentForm", "isolate"),
    # Clocks are shown with FMUs that have them.
    ("ComponentForm", "event_mode"),
}
"""Keys whose effect the tests below show in another way."""


def test_every_key_has_a_case() -> None:
    assert CASES.keys() | ELSEWHERE == KEYS
    assert {name for form, name in KEYS if form == "LinkForm"} == LINK_CASES.keys() | {
        "add_impairments"
    }


@pytest.mark.parametrize("key", sorted(CASES), ids=".".join)
def test_another_value_has_another_effect(key, tmp_path) -> None:
    common, one, two = CASES[key]
    first = effect(document(common, one), tmp_path / "one")
    again = effect(document(common, one), tmp_path / "again")
    assert first == again, "the same scenario has the same effect"
    assert first != effect(document(common, two), tmp_path / "two")


def effect(written: dict[str, Any], folder: Path) -> dict[str, Any]:
    """What a run did: its rows, its plan and what it says; not the scenario as it was written."""
    folder.mkdir(exist_ok=True)
    file = folder / "case.yaml"
    file.write_text(json.dumps(written))
    try:
        finished = run_scenario(load(file, forms=FORMS), folder / "run", figure=False)
    except CohapticError as error:
        if "real device" not in str(error):
            raise
        return {"refused": str(error).replace(str(folder), "")}
    content = finished.summary.content
    manifest = json.loads((finished.folder / "manifest.json").read_text())
    with open_run(finished.folder) as run:
        rows = digest(run)
    said = ("scenario", "status", "ticks", "base_rate", "expectations", "failures", "channels")
    said += ("message", "recorded", "measures")
    return {
        "rows": rows,
        **{name: content[name] for name in said},
        "components": {name: part.get("sha256") for name, part in manifest["components"].items()},
        "order": order(file),
    }


def order(file: Path) -> list[Any]:
    """What is done in a tick, one after the other."""
    plan = put_together(load(file), kinds=KINDS).plan
    return [(action.act.name, action.unit, action.names, action.period) for action in plan.every]


def test_playback_plays_the_component_that_is_named(tmp_path) -> None:
    recorded = tmp_path / "recorded.yaml"
    recorded.write_text(json.dumps(document(scenario_cases.THREE)))
    folders = [tmp_path / "first", tmp_path / "second"]
    run_scenario(load(recorded), folders[0], figure=False)
    run_scenario(
        load(recorded, (), ["components.a.parameters={gain: 3}"]), folders[1], figure=False
    )

    def played(name: str, folder: Path, of: str) -> dict[str, Any]:
        over = {"components": {"a": None, "b": {"python": None, "playback": str(folder), "of": of}}}
        return effect(document(over, {"connections": [], "channels": None}), tmp_path / name)

    first = played("one", folders[0], "b")
    assert first != played("two", folders[1], "b")
    assert first != played("three", folders[0], "c")


@pytest.mark.parametrize("key", sorted(LINK_CASES))
def test_a_link_obeys_each_of_its_settings(key) -> None:
    common, one, two = LINK_CASES[key]
    first = what_two_stations_do(read_link({**common, **one}, "link"))
    assert first == what_two_stations_do(read_link({**common, **one}, "link"))
    assert first != what_two_stations_do(read_link({**common, **two}, "link"))


def test_impairments_come_on_top_of_a_link_where_they_are_asked_for() -> None:
    def delays(asked: str) -> list[int]:
        sets = (f"link.add_impairments={asked}", "channels.lan.each_way_delay=2")
        half = split(put_together(load("two_users_box", (), sets, forms=FORMS)), "station_b")
        return [channel.forward.delay.ticks for channel in half.scenario.channels.values()]

    assert (delays("false"), delays("true")) == ([], [16])


def test_a_link_in_a_channel_goes_over_the_scenarios(tmp_path) -> None:
    def settings(*sets: str) -> Any:
        return (
            split(put_together(load("two_users_box", (), sets, forms=FORMS)), "station_a")
            .peers[0]
            .settings
        )

    plain, outer = settings(), settings("link.fade='70 ms'")
    inner = settings("link.fade='70 ms'", "channels.lan.link.fade='90 ms'")
    assert [each[0].fade for each in (plain, outer, inner)] == [0.05, 0.07, 0.09]


PREDICATES = sorted(
    name for form, name in KEYS if form == "ExpectForm" and name not in {"from", "to", "frequency"}
)


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory) -> Any:
    """A run with every predicate, plain and in a named window, by whether it can be met."""
    folder = tmp_path_factory.mktemp("expect")

    def run(name: str, conditions: dict[str, Any]) -> dict[str, Any]:
        expect = {"expect": {"a.x": {**conditions, "part": conditions}}}
        content = effect(document(expect), folder / name)
        return {(each["predicate"], each["label"]): each for each in content["expectations"]}

    def easy_limit(name: str) -> Any:
        measure, _, comparison = name.rpartition("_")
        # What no size could miss is refused.
        is_size = comparison == "above" and measure and MEASURES[measure].least == 0
        return 0 if is_size else wide[comparison]

    wide = {"below": 1e9, "above": -1e9, "within": [-1e9, 1e9], "equals": 0}
    never = {"below": -1e9, "above": 1e9, "within": [1e9, 2e9], "equals": 1e9}
    frequency = {"frequency": 100}
    easy = run("easy", frequency | {name: easy_limit(name) for name in PREDICATES})
    measured = {name: easy[name, ""]["measured"] for name in PREDICATES if name.endswith("_equals")}
    met = run("met", frequency | measured)
    hard = run("hard", frequency | {name: never[name.rpartition("_")[2]] for name in PREDICATES})
    return easy | met, hard


@pytest.mark.parametrize("window", ["", "part"])
@pytest.mark.parametrize("predicate", PREDICATES)
def test_a_predicate_is_met_or_not_as_its_threshold_says(predicate, window, verdicts) -> None:
    met, failed = verdicts
    assert not failed[predicate, window]["passed"]
    # A ramp has no single value to equal, and never falls to zero.
    assert met[predicate, window]["passed"] or predicate in {"equals", "loss_count_above"}


@pytest.mark.parametrize(("key", "other"), [("from", 0.05), ("to", 0.03), ("frequency", 700)])
@pytest.mark.parametrize("named", [False, True])
def test_a_window_says_what_is_measured(key, other, named, tmp_path) -> None:
    def measured(name: str, over: dict[str, Any]) -> Any:
        conditions = {"amplitude_below": 1e9, "max_below": 1e9, "min_below": 1e9, "from": 0.01}
        conditions |= {"to": 0.07, "frequency": 400, **over}
        expect = {"a.x": {"part": conditions} if named else conditions}
        return effect(document({"expect": expect}), tmp_path / name)["expectations"]

    assert measured("one", {}) != measured("two", {key: other})


def test_the_windows_keys_are_those_of_a_signal() -> None:
    window = {name for form, name in KEYS if form == "WindowForm"}
    assert window == {name for form, name in KEYS if form == "ExpectForm"}
    assert PARTS
