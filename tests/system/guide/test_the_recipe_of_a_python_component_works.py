"""The Python component of CONTRIBUTING.md runs as it stands there, beside its scenario."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import cohaptic

PAGE = Path(__file__).parents[3] / "CONTRIBUTING.md"
SCENARIO = """\
cohaptic: 1
duration: 0.25
rates: {control: 1024}
components:
  hand: {fmu: hand, parameters: {mass: 0.1, initial_position: 50 mm}}
  spring: {python: "my_parts:Spring", parameters: {stiffness: 100 N/m}}
connections:
  - hand.position -> spring.position
  - spring.force -> hand.force
"""


def test_the_spring_pulls_the_hand_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (found,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "my_parts.py").write_text(found, encoding="utf-8")
    (tmp_path / "spring.yaml").write_text(SCENARIO, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    finished = cohaptic.run(cohaptic.load("spring.yaml"), figure=False)
    assert finished.summary.status == 0
    with cohaptic.open_run(finished.folder) as run:
        position, force = run["hand.position"].values, run["spring.force"].values
    assert np.array_equal(force, -100.0 * np.asarray(position))
    assert position[0] == 0.05
    assert min(position) < -0.04
