"""``cohaptic play`` in a browser: hands pinch, two pages carry, the page measures the ripple."""

from __future__ import annotations

import time

import pytest
from click.testing import CliRunner

from cosim.cli import cli
from cosim.record.digest import digest
from cosim.record.reader import open_run
from tests.browser.conftest import command, readout, shown, until

pytestmark = pytest.mark.browser

ALL_TOUCH = (
    "cohaptic.run.scene.fingers.filter((f) => f.force.length)"
    ".every((f) => Math.hypot(...f.force.map(cohaptic.value)) > 0.3)"
)


@pytest.fixture
def play(tmp_path):
    """Start ``cohaptic play``; its address, and where the take is recorded."""
    opened = []

    def start(*words: str):
        made = command("play", *words, "--no-browser", "--out", str(tmp_path / "take"))
        opened.append(made)
        return made.__enter__()[0]

    yield start, tmp_path / "take"
    for each in opened:
        each.__exit__(None, None, None)


@pytest.fixture(scope="module")
def goes_on(tmp_path_factory):
    """The address of one long take, for tests that leave it as they found it."""
    out = tmp_path_factory.mktemp("play") / "take"
    with command("play", "--no-browser", "--duration", "600", "--out", str(out)) as (address, _):
        yield address


def place(page, x=0.0, y=0.0):
    """Pixels of a place beside the middle of the scene (px, upwards)."""
    box = page.locator("#scene").bounding_box()
    return box["x"] + box["width"] / 2 + x, box["y"] + box["height"] / 2 - y


def pinch(page, y=0.0):
    """Move over the box and hold the button."""
    page.mouse.move(*place(page, 0, y + 10))
    page.mouse.move(*place(page, 0, y))
    time.sleep(0.4)
    page.mouse.down()


def box(page, name="vr_a"):
    """Where a copy of the box is (m)."""
    return [page.evaluate(f"cohaptic.value('{name}.box_pose.{axis}')") for axis in "xy"]


def carry(page, x, y, steps=40):
    """Move the mouse there in small steps."""
    middle = place(page)
    for step in range(1, steps + 1):
        page.mouse.move(middle[0] + x * step / steps, middle[1] - y * step / steps)
        time.sleep(0.02)


def test_one_mouse_pinches_and_carries_and_the_take_runs_again(chromium, play):
    start, take = play
    address = start()
    with shown(chromium, address) as page:
        assert page.inner_text("#help").count(".") == 1, "one sentence of help"
        until(page, "cohaptic.run.scene.pointers.length === 2")
        pinch(page)
        until(page, ALL_TOUCH)
        before = box(page)
        carry(page, 40, 50)
        until(page, f"cohaptic.value('vr_a.box_pose.y') > {before[1] + 0.02}")
        page.mouse.up()
        time.sleep(0.5)
        # The fresh run's time is below any time of this one, whenever it is looked at.
        stood = page.evaluate("cohaptic.time")
        page.click("#restart")
        until(page, f"cohaptic.time !== null && cohaptic.time < {stood}", 60)
    with open_run(take) as run:
        assert run["pointer_station_a.valid"][:].any()
        recorded, ticks = digest(run), run.ticks
    again = take.with_name("again")
    done = CliRunner().invoke(cli, ["play", "--again", str(take), "--out", str(again)])
    assert done.exit_code == 0, done.output
    with open_run(again) as run:
        assert run.ticks == ticks
        assert digest(run) == recorded


def test_two_pages_are_two_users(chromium, play):
    address = play[0]()
    with shown(chromium, address, 700) as one, shown(chromium, address, 700) as other:
        assert one.evaluate("document.getElementById('user').value") == "station_a"
        until(other, "document.getElementById('user').value === 'station_b'")
        pinch(one, 0)
        pinch(other, -20)
        until(one, ALL_TOUCH)
        before = box(one, "vr_b")
        (x, y), (u, v) = place(one), place(other, 0, -20)
        for step in range(1, 31):
            one.mouse.move(x + 1.5 * step, y - step)
            other.mouse.move(u + 1.5 * step, v - step)
            time.sleep(0.02)
        until(other, f"cohaptic.value('vr_b.box_pose.x') > {before[0] + 0.01}")
        assert max(apart(one), apart(other)) < 0.01


def apart(page):
    """How far the copies are apart (m)."""
    (ax, ay), (bx, by) = box(page, "vr_a"), box(page, "vr_b")
    return ((ax - bx) ** 2 + (ay - by) ** 2) ** 0.5


@pytest.mark.parametrize("delay", [1, 2])
def test_the_ripple_at_b_breaks_out_under_centralized_control_alone_in_one_run(
    chromium, play, delay
):
    address = play[0]("--set", f"channels.lan.round_trip_delay={delay}")
    with shown(chromium, address) as page:
        until(page, "cohaptic.run.scene.pointers.length === 2")
        pinch(page)
        until(page, ALL_TOUCH, 30)
        for control, expected in (
            ("distributed", (0, 0.2)),
            ("centralized", (0.5, 10)),
            ("distributed", (0, 0.2)),
        ):
            if not page.is_checked(f"#knob-control [value={control}]"):
                page.keyboard.press("c")
            until(page, f"document.getElementById('world').textContent === '{control}'")
            radius = float(page.get_attribute("#radius", "data-value"))
            assert (radius < 1) == (control == "distributed")
            # At rest friction holds any grasp: it is moved a little, and then held still.
            carry(page, 10, 10, 20)
            carry(page, 0, 0, 20)
            moment = page.evaluate("cohaptic.time")
            until(page, f"cohaptic.time > {moment} + 2", 60)
            time.sleep(0.4)
            assert expected[0] <= readout(page, "ripple-b") < expected[1], control


def test_the_delay_that_a_page_turns_up_is_what_breaks_the_grasp(chromium, play):
    address = play[0]("two_users_box_centralized", "--set", "channels.lan.round_trip_delay=0")
    with shown(chromium, address) as page:
        until(page, "cohaptic.run.scene.pointers.length === 2")
        pinch(page)
        until(page, ALL_TOUCH, 30)
        found = []
        for delay in (0, 2, 0):
            page.fill("[id='knob-lan.round_trip_delay']", str(delay))
            unstable = ">= 1" if delay else "< 1.01"
            until(page, f"Number(document.getElementById('radius').dataset.value) {unstable}")
            moment = page.evaluate("cohaptic.time")
            worst = 0.0
            while page.evaluate("cohaptic.time") < moment + 4:
                carry(page, 8, 8, 6)
                carry(page, 0, 0, 6)
                if page.evaluate("cohaptic.time") > moment + 2:
                    worst = max(worst, readout(page, "ripple-b"))
            found.append(worst)
        assert found[1] > 0.5
        assert found[1] > 2 * max(found[0], found[2])


def test_keys_touches_and_a_gamepad_are_hands_too(chromium, goes_on):
    with shown(chromium, goes_on, has_touch=True) as page:
        until(page, "cohaptic.run.scene.pointers.length === 2")
        valid = "cohaptic.value('pointer_station_a.valid')"
        page.focus("#scene")
        page.keyboard.down(" ")
        until(page, f"{valid} === 1")
        where = "cohaptic.value('pointer_station_a.position_1[2]')"
        before = page.evaluate(where)
        page.keyboard.down("ArrowUp")
        until(page, f"{where} > {before} + 0.01")
        page.keyboard.up("ArrowUp")
        page.keyboard.up(" ")
        session = page.context.new_cdp_session(page)
        touches = [
            {"x": x, "y": y, "id": n}
            for n, (x, y) in enumerate((place(page, -45, 20), place(page, 60, 45)))
        ]
        for kind in ("touchStart", "touchMove"):
            session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})
        until(page, f"{where.replace('position_1', 'position_2')} - {where} > 0.01")
        session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        page.evaluate(
            "navigator.getGamepads = () => [{connected: true, axes: [1, 0],"
            " buttons: [{pressed: true}]}]"
        )
        across = "cohaptic.value('pointer_station_a.position_1[1]')"
        before = page.evaluate(across)
        until(page, f"Math.abs({across} - {before}) > 0.01")


def test_a_page_that_goes_is_nobody_and_its_hand_lets_go(chromium, goes_on):
    with shown(chromium, goes_on, 700) as stays:
        page_context = chromium.new_context()
        page = page_context.new_page()
        page.goto(goes_on)
        until(page, "globalThis.cohaptic && cohaptic.time !== null")
        until(page, "document.getElementById('user').value === 'station_b'")
        pinch(page, -20)
        until(stays, "cohaptic.value('pointer_station_b.valid') === 1")
        page_context.close()
        until(stays, "cohaptic.value('pointer_station_b.valid') === 0")
        until(stays, "!document.querySelector('#user option[value=station_b]').disabled")


def test_pause_step_and_slow_motion(chromium, goes_on):
    with shown(chromium, goes_on) as page:
        page.click("#pause")
        until(page, "document.getElementById('pause').getAttribute('aria-pressed') === 'true'")
        time.sleep(0.4)
        stood = page.evaluate("cohaptic.time")
        time.sleep(0.4)
        assert page.evaluate("cohaptic.time") == stood
        page.click("#step")
        until(page, f"cohaptic.time > {stood}")
        time.sleep(0.2)
        assert page.evaluate("cohaptic.time") == pytest.approx(stood + 1 / 1024, abs=1e-5)
        page.select_option("#speed", "0.1")
        page.click("#pause")
        until(page, f"cohaptic.time > {stood} + 0.02")
        began, moment = time.monotonic(), page.evaluate("cohaptic.time")
        time.sleep(1.5)
        passed = page.evaluate("cohaptic.time") - moment
        assert passed / (time.monotonic() - began) < 0.2
        page.select_option("#speed", "1")
        moment = page.evaluate("cohaptic.time")
        until(page, f"cohaptic.time > {moment} + 0.5", 2)


def test_the_switch_is_on_the_first_screen_and_a_sample_is_one(chromium, goes_on):
    with shown(chromium, goes_on, 1000, 800) as page:
        until(page, "document.getElementById('knob-control')")
        switch = page.locator("#knob-control").bounding_box()
        assert switch["y"] + switch["height"] <= 800
        knob = "[id='knob-lan.round_trip_delay']"
        for value, told in (("2", "2 samples"), ("1", "1 sample")):
            page.fill(knob, value)
            assert page.inner_text(f"{knob} + output") == told
