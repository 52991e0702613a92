"""Debian's Chromium, and runs with their live page."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager

import pytest

ADDRESS = re.compile(r"(http|ws)://\S+")


@pytest.fixture(scope="session")
def chromium():
    from playwright.sync_api import sync_playwright

    path = shutil.which("chromium")
    assert path, "there is no Chromium: apt-get install chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


@contextmanager
def command(*words: str):
    """A cohaptic command that serves; the first address, and what it has said so far."""
    process = subprocess.Popen(
        [sys.executable, "-c", "from cosim.cli import main; main()", *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    said: list[str] = []
    reader = threading.Thread(target=lambda: said.extend(process.stderr), daemon=True)
    try:
        for line in process.stderr:
            said.append(line)
            if found := ADDRESS.search(line):
                break
        else:
            pytest.fail(f"no page was served: {''.join(said)}")
        reader.start()
        process.said = said
        yield found[0], process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.wait(30)
        if reader.ident is not None:
            reader.join()
        process.stderr.close()


@contextmanager
def shown(browser, address, width=1000, height=800, **options):
    """A page that is open, and what went wrong in it, which has to be nothing."""
    context = browser.new_context(viewport={"width": width, "height": height}, **options)
    page = context.new_page()
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda said: wrong.append(said.text) if said.type == "error" else None)
    page.goto(address)
    try:
        until(page, "cohaptic.time !== null")
        yield page
        assert wrong == []
    finally:
        context.close()


def until(page, expression, seconds=15.0, ready="cohaptic"):
    """Wait until an expression holds in the page, and return its value."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = page.evaluate(f"globalThis.{ready} ? ({expression}) : null")
        if value:
            return value
        time.sleep(0.05)
    return pytest.fail(f"never came: {expression}")


def readout(page, key):
    """A number of the page's list."""
    text = page.evaluate(f"document.querySelector('[data-key=\"{key}\"]')?.textContent ?? ''")
    found = re.search(r"-?\d+(\.\d+)?", text)
    return float(found[0]) if found else None
