"""A small valid scenario that tests change, and a way to load text as one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.scenario import Scenario, load
from tests.support.scenario.small_scenario import SMALL


@pytest.fixture
def small() -> str:
    return SMALL


@pytest.fixture
def scenario_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Scenario]:
    """Loads text as ``s.yaml`` of an empty working folder, with overlay texts and overrides."""
    monkeypatch.chdir(tmp_path)

    def make(text: str, *overlays: str, sets: tuple[str, ...] = ()) -> Scenario:
        (tmp_path / "s.yaml").write_text(text, encoding="utf-8")
        names: list[str] = []
        for number, overlay in enumerate(overlays, start=1):
            names.append(f"o{number}.yaml")
            (tmp_path / names[-1]).write_text(overlay, encoding="utf-8")
        return load("s.yaml", names, sets)

    return make
