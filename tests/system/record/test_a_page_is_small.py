"""A minute of anything that is bundled makes a page of at most 5 MB."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.reading import load
from cosim.run import run_scenario

MOST = 5_000_000


@pytest.mark.parametrize("name", ["two_users_box", "two_users_box_centralized"])
def test_sixty_seconds_take_five_megabytes_at_most(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    run_scenario(load(name, (), ["duration=60 s", "expect={}"]), folder, figure=False, page=True)
    size = (folder / "report.html").stat().st_size
    print(f"{name}: {size / 1e6:.2f} MB")
    assert size <= MOST
