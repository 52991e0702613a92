"""Two people at two stations, each with a page, over a real link that delays and loses packets."""

from __future__ import annotations

import threading
import time
from contextlib import ExitStack

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.cli import cli
from cosim.link.wire.address import Address
from cosim.record.reader import open_run
from cosim.testing.impairment import BadNetwork, Impairer
from cosim.testing.proxy import Proxy
from tests.browser.conftest import command, shown, until
from tests.browser.readable import broken_words, too_faint
from tests.browser.test_people_carry_a_box import ALL_TOUCH, box, pinch, place
from tests.support.link.processes import free_ports

pytestmark = pytest.mark.browser

NETWORK = BadNetwork(delay=2e-3, jitter=0.5e-3, loss=0.01)
"""Each way."""


@pytest.fixture
def network():
    """The ports that station_a and station_b see, with the proxy between them."""
    ports = free_ports()
    ways = [Impairer(NETWORK, seed) for seed in (1, 2)]
    proxy = Proxy(Address("127.0.0.1", 0), Address("127.0.0.1", ports[0]), *ways)
    stop = threading.Event()
    relay = threading.Thread(target=proxy.run, args=(stop,))
    relay.start()
    yield {
        "station_a": (ports[0], proxy.inner_address.port),
        "station_b": (ports[1], proxy.address.port),
    }
    stop.set()
    relay.join()


def test_both_copies_agree_as_the_measured_link_foretells(chromium, network, tmp_path):
    with ExitStack() as stack:
        addresses = []
        for name, (own, other) in network.items():
            address, _ = stack.enter_context(
                command(
                    *("station", "two_users_box", "--as", name, "--play", "--duration", "120"),
                    *("--listen", f"127.0.0.1:{own}", "--peer", f"127.0.0.1:{other}"),
                    *("--wait", "60", "--no-figure", "--no-report", "--out", str(tmp_path / name)),
                )
            )
            addresses.append(address)
        pages = [stack.enter_context(shown(chromium, address, 700)) for address in addresses]
        for page, name in zip(pages, network, strict=True):
            until(page, f"document.getElementById('user').value === '{name}'")
            assert page.is_hidden("#pace"), "a real link keeps its pace"
            assert page.is_hidden("#knobs"), "knobs are part of the contract"
        for page, y in zip(pages, (0, -20), strict=True):
            pinch(page, y)
        for page in pages:
            until(page, ALL_TOUCH)
        before = box(pages[0], "vr_a")[1], box(pages[1], "vr_b")[1]
        middles = [place(page, 0, y) for page, y in zip(pages, (0, -20), strict=True)]
        for step in range(1, 51):
            for page, (x, y) in zip(pages, middles, strict=True):
                page.mouse.move(x, y - step)
            time.sleep(0.02)
        for page, name, start in zip(pages, ("vr_a", "vr_b"), before, strict=True):
            until(page, f"cohaptic.value('{name}.box_pose.y') > {start} + 0.01", 30)
    merged, again = tmp_path / "merged", tmp_path / "again"
    run = CliRunner().invoke
    done = run(cli, ["merge", *(str(tmp_path / name) for name in network), "--out", str(merged)])
    assert done.exit_code == 0, done.output
    the_page_has_both(chromium, merged / "report.html")
    replay = ["play", "--again", str(merged), "--with", str(merged / "measured.yaml")]
    done = run(cli, [*replay, "--out", str(again)])
    assert done.exit_code == 0, done.output
    with open_run(merged) as real, open_run(again) as foretold:
        apart = drift(real)
        assert real["pointer_station_a.valid"][:].any()
        assert real["pointer_station_b.valid"][:].any()
        assert apart.max() < 0.01
        until_lost = both_counted(real)
        assert until_lost > 0
        assert np.abs(apart - drift(foretold))[:until_lost].max() < 1e-9


def the_page_has_both(chromium, file):
    """The merged page: both copies in one scene, both stations' numbers, and the theory."""
    for width in (1600, 1000, 400):
        for scheme in ("light", "dark"):
            it_fits(chromium, file, width, scheme)
    context = chromium.new_context(viewport={"width": 400, "height": 800})
    page = context.new_page()
    page.goto(f"file://{file}")
    until(page, "document.documentElement.dataset.ready === 'yes'", ready="report")
    table = page.locator("section[aria-labelledby=stations]").inner_text()
    for told in ("station_a", "station_b", "round trip", "deadlines: misses"):
        assert told in table
    assert "spectral radius" in page.locator("section[aria-labelledby=theory]").inner_text()
    named = page.locator("#stage").inner_text()
    assert "station_a" in named
    assert "station_b" in named
    assert too_faint(page) == []
    context.close()


def it_fits(chromium, file, width, scheme):
    """Nothing sticks out, no word of a table is broken, and the links' numbers are in sight."""
    context = chromium.new_context(viewport={"width": width, "height": 800}, color_scheme=scheme)
    page = context.new_page()
    page.goto(f"file://{file}")
    until(page, "document.documentElement.dataset.ready === 'yes'", ready="report")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert broken_words(page) == []
    assert too_faint(page) == []
    numbers = page.locator("section[aria-labelledby=stations] tbody tr:first-child td:last-child")
    place = numbers.bounding_box()
    assert place["x"] + place["width"] <= width
    context.close()


def both_counted(run):
    """The tick at which a peer was given up, from when on the measured delays foretell nothing."""
    weights = [run[name][:] for name in run.signals if name.endswith(".weight")]
    reduced = np.max([weight < 1.0 for weight in weights], axis=0)
    begun = int(np.argmin(reduced))
    given_up = np.flatnonzero(reduced[begun:])
    return begun + int(given_up[0]) if len(given_up) else run.ticks


def drift(run):
    """How far the copies are apart at every tick (m)."""
    return np.hypot(
        *(run[f"vr_a.box_pose.{axis}"][:] - run[f"vr_b.box_pose.{axis}"][:] for axis in "xy")
    )
