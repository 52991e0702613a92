"""Every command that a page shows in a block is run, page by page, in an empty folder.

What is not run is listed here with the reason; a command that is new is run, or joins the list.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.guide.blocks import ROOT, blocks_of, commands

BOARD = "needs a board; tests/system/hil and tests/timed/hil run it on emulated ones"
STATIONS = "needs several machines at once; tests/system/link and tests/timed/link run stations"
BROWSER = "opens a page until somebody ends it; tests/browser does"
MINUTES = "takes minutes"
NOT_RUN = {
    "README.md": {
        "pip install uv": "sets the machine up",
        "uv run pytest -n 2": "that is this",
        "uv run cohaptic play": BROWSER,
        "uv run cohaptic new mine.yaml": "asks; tests/system/cli answers it",
        "uv run cohaptic sweep": f"{MINUTES}; tests/system/sweep runs the map",
        "uv run cohaptic thesis": f"{MINUTES}; tests/system/thesis runs the experiments",
    },
    "docs/ci.md": {
        "cohaptic run scenarios/*.yaml": f"{MINUTES}; tests/system/scenario runs each of them",
        "docker": "needs Docker",
    },
    "docs/force-sensor.md": {
        "cohaptic device check": BOARD,
        "cohaptic device conform": BOARD,
        "cohaptic device emulate": "serves until somebody ends it; tests/system/hil does",
    },
    "docs/hardware.md": {
        **dict.fromkeys(("cohaptic device check", "cohaptic device calibrate"), BOARD),
        "cohaptic run two_users_box --with scenarios/devices/haply.yaml": BOARD,
        "cohaptic device emulate": "serves until somebody ends it; tests/system/hil does",
        "cohaptic doctor": "says what this machine lacks; tests/system/cli reads it",
    },
    "docs/identify.md": {"cohaptic": BOARD},
    "docs/index.md": {"pip install uv": "sets the machine up"},
    "docs/link.md": {
        **dict.fromkeys(("cohaptic station", "cohaptic merge", "cohaptic netchar"), STATIONS),
        "cohaptic run merged/scenario.resolved.yaml": STATIONS,
    },
    "docs/live.md": {
        **dict.fromkeys(("cohaptic play", "cohaptic live", "cohaptic merge"), BROWSER),
        "cohaptic station": STATIONS,
        "cohaptic run two_users_box --realtime --live": BROWSER,
    },
    "docs/master.md": {
        "git clone": "fetches",
        "COHAPTIC_REFERENCE_FMUS": "needs what was fetched; tests/peers does",
    },
    "docs/release.md": {
        **dict.fromkeys(("uv run pytest", "uv run python bench", "WHEEL_PYTHON"), MINUTES),
        "uv run --group docs": "the last lane of .ci/run",
        **dict.fromkeys(("git", "uv build", "uv publish"), "is the release itself"),
        "docker": "needs Docker",
    },
    "docs/sweeps.md": {"cohaptic sweep": f"{MINUTES}; tests/system/sweep runs the map"},
    "docs/tutorial.md": {"uv run cohaptic": "test_the_tutorial_is_true compares its answers"},
}
"""By page and how a line begins: why it is not run."""
BEFORE = {
    "docs/people.md": ["cohaptic run two_users_box --out=runs/mine"],
    "docs/record.md": [
        f"cohaptic run two_users_box --set duration=2.5 --set 'expect=~' --out=runs/{name}"
        for name in ("one", "other")
    ],
    "docs/study.md": ["cohaptic study run delay.yaml --participant P03 --emulate"],
}
"""What a page takes to be there already."""
LAN = ROOT / "scenarios" / "presets" / "lan_2006.yaml"
"""What somebody's network may have been measured as."""
STATUS = {"cohaptic check two_users_box --set duratoin=2": 2}
"""How a line ends that does not end well, by how it begins."""

SHOWN = commands()
SECONDS = 240


def reason(page: str, line: str) -> str | None:
    """Why a line is not run; ``None``: it is."""
    listed = NOT_RUN.get(page, {})
    return next((why for begins, why in listed.items() if line.startswith(begins)), None)


RUN = sorted({shown.page for shown in SHOWN if reason(shown.page, shown.line) is None})


def test_there_are_many_and_nothing_is_listed_that_is_not_shown() -> None:
    assert len(SHOWN) > 90
    for page, listed in NOT_RUN.items():
        lines = [shown.line for shown in SHOWN if shown.page == page]
        for begins in listed:
            assert any(line.startswith(begins) for line in lines), f"{page}: {begins}"
    for page in BEFORE:
        assert page in RUN
    for begins in STATUS:
        assert any(shown.line.startswith(begins) for shown in SHOWN), begins
    assert sum(reason(each.page, each.line) is None for each in SHOWN) > 40


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    """An empty one, but for the scenarios that come with the package."""
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("page", RUN)
def test_every_command_of_a_page_ends_as_it_should(page: str, folder: Path) -> None:
    for name, text in files_of(page):
        (folder / name).write_text(text, encoding="utf-8")
    shown = [each.line for each in SHOWN if each.page == page and reason(page, each.line) is None]
    here = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    for line in [*BEFORE.get(page, []), *shown]:
        done = subprocess.run(
            ["bash", "-c", line.removeprefix("uv run ")],
            cwd=folder,
            env={**os.environ, "PATH": here},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=SECONDS,
            check=False,
        )
        expected = next((code for begins, code in STATUS.items() if line.startswith(begins)), 0)
        assert done.returncode == expected, f"{line}\n{done.stdout}{done.stderr}"
        assert done.stdout or done.stderr, f"{line} says nothing"


def files_of(page: str) -> Iterator[tuple[str, str]]:
    """What stands on the page as a file with a name, or is measured elsewhere."""
    for kind, text in blocks_of(ROOT / page):
        if kind == "yaml" and (named := re.match(r"# (\w+\.yaml)\n", text)):
            yield named[1], text
    if page == "docs/study.md":
        (plan,) = [
            text for kind, text in blocks_of(ROOT / page) if kind == "yaml" and "study: 1" in text
        ]
        assert "duration=8" in plan
        yield "delay.yaml", plan.replace("duration=8", "duration=0.05")
    if page == "docs/link.md":
        yield "lan.yaml", LAN.read_text(encoding="utf-8")
