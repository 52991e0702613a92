"""Scenarios written into a test's folder and loaded as a user's would be."""

from __future__ import annotations

from pathlib import Path

from cosim.scenario import Scenario, load

HEAD = """\
cohaptic: 1
title: A scenario for tests
duration: 2
rates: {control: 1024, network: 128}
components:
  a: {python: "somewhere:Something", rate: control}
  b: {python: "somewhere:Something", rate: control}
"""


def scenario(folder: Path, *lines: str) -> Scenario:
    path = folder / "small.yaml"
    path.write_text(HEAD + "\n".join(lines) + "\n")
    return load(path)
