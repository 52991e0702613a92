"""``--realtime`` leaves the record that the same run has without a pace: numbers and texts."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from cosim.record.digest import digest
from cosim.record.reader import open_run
from tests.support.master.master_support import scenario_of
from tests.unit.master.test_texts_travel_like_numbers import fmu_pair

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="a paced run needs a fork")


@pytest.mark.parametrize("keys", [{}, {"isolate": "process"}])
def test_the_digest_is_the_same(tmp_path: Path, keys: dict[str, str]) -> None:
    """Of a Python component and of an FMU that hands its texts on, also in a process of its own."""
    scenario_of(tmp_path, fmu_pair(tmp_path, 3, **keys))
    found = []
    for name, options in (("free", ()), ("paced", ("--realtime",))):
        command = [sys.executable, "-c", "from cosim.cli import main; main()", "run", "test.yaml"]
        done = subprocess.run(
            [*command, "--out", name, "--no-figure", *options],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        with open_run(tmp_path / name) as run:
            assert len(run.texts["two.word"].values) > 60
            found.append(digest(run))
    assert found[0] == found[1]
    deadlines = json.loads((tmp_path / "paced" / "manifest.json").read_text())["deadlines"]
    assert (deadlines["lost_rows"], deadlines["lost_texts"]) == (0, 0)
