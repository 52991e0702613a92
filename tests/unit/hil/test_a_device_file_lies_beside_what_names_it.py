"""``file:`` of a device starts from the folder of the file that names it, and the docs name the
same files as the overlays that come with cohaptic."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cosim.scenario import load

ROOT = Path(__file__).parents[3]
OVERLAYS = sorted((ROOT / "scenarios" / "devices").glob("*.yaml"))
FILE = re.compile(r'device: \{url: "(\w+)[^"]*", file: (\S+)\}')
BESIDE = '{url: "haply:///dev/ttyACM0", file: mine.yaml}'


@pytest.mark.parametrize("where", ["overlay", "scenario", "--set"])
def test_it_is_looked_for_beside_the_file_that_names_it(tmp_path: Path, monkeypatch, where: str):
    """And not in the working folder, where another device's may lie."""
    bench, working = tmp_path / "bench", tmp_path / "working"
    bench.mkdir()
    working.mkdir()
    monkeypatch.chdir(working)
    finger = f"components:\n  finger_a1: {{device: {BESIDE}}}\n  operator_a1: ~\n"
    overlay = bench / "over.yaml"
    overlay.write_text("title: none\n" if where == "--set" else finger)
    if where == "scenario":
        (bench / "whole.yaml").write_text(f"cohaptic: 1\ninclude: two_users_box\n{finger}")
        found = load(bench / "whole.yaml")
    else:
        said = [f"components.finger_a1.device={BESIDE}", "components.operator_a1=~"]
        found = load("two_users_box", [overlay], said if where == "--set" else [])
    folder = working if where == "--set" else bench
    assert found.components["finger_a1"].options["file"] == str(folder / "mine.yaml")


def test_the_docs_write_the_file_that_the_overlay_reads():
    named = {
        driver: file for path in OVERLAYS for driver, file in FILE.findall(path.read_text("utf-8"))
    }
    assert set(named) >= {"haply", "cobs", "odrive", "canopen", "cia402"}
    pages = [ROOT / "docs" / f"{page}.md" for page in ("hardware", "safety", "identify", "driver")]
    commands = [
        line
        for page in pages
        for line in page.read_text("utf-8").splitlines()
        if "cohaptic " in line
    ]
    told: set[str] = set()
    for line in commands:
        for driver, file in named.items():
            if f"{driver}:///" in line or f"{driver}+" in line:
                files = set(re.findall(r"\S+\.device\.yaml", line))
                assert files <= {file}, line
                told |= files
    assert "haply.device.yaml" in told
    assert not any(
        re.search(r"calibrate \S+ (?!\S+\.device\.yaml)\S+\.yaml", line) for line in commands
    )
