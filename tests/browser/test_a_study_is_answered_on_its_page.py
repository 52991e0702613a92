"""``cohaptic study --web``: emulated participants answer in a browser, leave, and come back."""

from __future__ import annotations

import json

import pytest

from cosim.record.reader import open_run
from tests.browser.conftest import command, until

pytestmark = pytest.mark.browser

PLAN = """\
study: 1
title: What trembles
scenario: single_axis_distributed
set: [duration=1.5]
seed: 5
conditions:
  weak: {set: [components.coupler_o1.parameters.stiffness=300]}
  strong: {set: [components.coupler_o1.parameters.stiffness=600]}
trials: 2
staircase:
  {vary: lan.round_trip_delay, least: 0, most: 16, start: 8, steps: [4, 2, 1], answer: noticed}
questions:
  noticed: {ask: "Did it tremble?"}
  comfort: {ask: "How comfortable was it?", kind: scale, least: 1, most: 7, labels: [bad, good]}
  hand: {ask: "Which hand?", kind: choice, labels: [left, right]}
  newtons: {ask: "How strong (N)?", kind: number, least: 0, most: 20}
  words: {ask: "Anything else?", kind: text}
after_condition: [nasa_tlx]
break: {every: 2, least: 1}
"""


CARRIED = """\
study: 1
scenario: two_users_box
set: [duration=4, expect=~]
conditions: {one: {}}
trials: 1
questions: {held: {ask: "Did you hold it?"}}
"""


@pytest.fixture(name="study")
def _study(tmp_path):
    (tmp_path / "plan.yaml").write_text(PLAN)
    log = tmp_path / "study" / "people" / "P1" / "log.jsonl"

    def begin():
        words = ("study", str(tmp_path / "plan.yaml"), "--participant", "P1", "--web")
        return command(*words, "--out", str(tmp_path / "study"))

    def steps():
        return [json.loads(line) for line in log.read_text().splitlines()]

    return begin, steps


@pytest.fixture(name="opened")
def _opened(chromium):
    """A page without anything going wrong in it, but a server that ends."""
    pages = []

    def show(address):
        context = chromium.new_context(viewport={"width": 900, "height": 800})
        page = context.new_page()
        wrong: list[str] = []
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.goto(address)
        pages.append((context, wrong))
        return page

    yield show
    for context, wrong in pages:
        context.close()
        assert wrong == []


def heading(page, text):
    until(
        page,
        f"document.querySelector('#sheet:not([hidden], [inert]) h2')?.textContent === '{text}'",
    )


def press(page, name):
    page.get_by_role("button", name=name).click()


def answer(page, trial, *, noticed):
    heading(page, f"After trial {trial}")
    page.check(f"#question-noticed input[value={noticed}]")
    page.check("#question-comfort input[value='5']")
    page.check("#question-hand input[value=right]")
    page.fill("#question-newtons input", "2.5")
    page.fill("#question-words textarea", f"<b>trial</b> {trial} äß")
    press(page, "Go on")


def workload(page):
    heading(page, "About the trials until now")
    page.set_viewport_size({"width": 400, "height": 800})
    ends = [end.bounding_box() for end in page.locator("#sheet .end").all()]
    assert all(low["y"] == high["y"] for low, high in zip(ends[::2], ends[1::2], strict=True))
    page.set_viewport_size({"width": 900, "height": 800})
    for number, slider in enumerate(page.locator("input[type=range]").all()):
        slider.fill(str(10 * number))
    press(page, "Go on")


def test_a_study_is_answered_left_and_taken_up_again(study, opened):
    begin, steps = study
    with begin() as (address, process):
        page = opened(address)
        heading(page, "Welcome.")
        assert page.inner_text("#name") == "What trembles"
        assert not page.locator("#side").is_visible(), "delays and signals tell the condition"
        press(page, "Begin")
        until(page, "document.getElementById('state').textContent === 'Trial 1 of 4.'")
        until(page, "cohaptic.time !== null")
        answer(page, 1, noticed="y")
        heading(page, "After trial 2")
        press(page, "Go on")
        until(page, "document.querySelectorAll('#sheet [data-problem]').length === 4")
        assert "a number from 0 to 20" in page.inner_text("#question-newtons")
        page.fill("#question-newtons input", "3")
        press(page, "Go on")
        until(page, "document.querySelectorAll('#sheet [data-problem]').length === 3")
        assert page.input_value("#question-newtons input") == "3", "what is right stays"
        answer(page, 2, noticed="n")
        heading(page, "About the trials until now")
        press(page, "Go on")
        until(page, "document.querySelectorAll('#sheet [data-problem]').length === 6")
        workload(page)
        heading(page, "Rest as long as you like.")
        assert page.locator("#sheet button[type=submit]").is_disabled()
        page.reload()
        page.get_by_role("button", name="Go on", exact=True).click(timeout=5000)
        heading(page, "After trial 3")
        press(page, "Leave the study")
        assert process.wait(20) == 1
        heading(page, "The session is over. Thank you.")
    assert "the same command goes on" in "".join(process.said)
    head, first, second, form, rest = steps()
    assert head["emulated"] is False
    ticked = {"noticed": True, "comfort": 5.0, "hand": "right", "newtons": 2.5}
    assert first["answers"] == {**ticked, "words": "<b>trial</b> 1 äß"}
    assert second["answers"]["noticed"] is False
    assert list(form["answers"].values()) == [0.0, 10.0, 20.0, 30.0, 40.0, 50.0]
    assert rest["seconds"] >= 1
    with begin() as (address, process):
        page = opened(address)
        heading(page, "Welcome.")
        press(page, "Begin")
        answer(page, 3, noticed="y")
        answer(page, 4, noticed="y")
        workload(page)
        assert process.wait(20) == 0
    assert "P1 goes on after 2 of 4 trials." in "".join(process.said)
    assert [each["trial"] for each in steps() if "trial" in each] == [1, 2, 3, 4]
    assert len(steps()) == 8


def test_a_participant_moves_a_hand_in_the_trial(tmp_path, opened):
    plan, study = tmp_path / "plan.yaml", tmp_path / "study"
    plan.write_text(CARRIED)
    words = ("study", str(plan), "--participant", "P1", "--web", "--hands", "--out", str(study))
    with command(*words) as (address, process):
        page = opened(address)
        heading(page, "Welcome.")
        press(page, "Begin")
        until(page, "cohaptic.run?.scene.pointers.length === 2 && cohaptic.time !== null")
        box = page.locator("#scene").bounding_box()
        for step in range(20):
            page.mouse.move(box["x"] + box["width"] / 2 + step, box["y"] + box["height"] / 2)
        assert not page.locator("#pace").is_visible(), "a trial keeps its pace"
        heading(page, "After trial 1")
        page.check("#question-held input[value=y]")
        press(page, "Go on")
        assert process.wait(30) == 0
    with open_run(study / "people" / "P1" / "trial-001") as run:
        assert run["pointer_station_a.valid"].values.any()
        assert len(set(run["pointer_station_a.position_1[1]"].values)) > 2
