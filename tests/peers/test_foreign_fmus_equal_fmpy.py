"""Sixty FMUs of other makers give the bits that FMPy's low-level API gives at the same times.

``uv run --group peers pytest -m peers tests/peers/test_foreign_fmus_equal_fmpy.py``; see
``tests/support/peers/corpus.py`` for where they come from. Each runs in processes of its own, here
and there, for forty of its own steps, or of 10 ms where it does not say.
"""

from __future__ import annotations

import json
import platform
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from cosim.master.fmu.reading import read_description
from cosim.record.reader import open_run
from tests.support.peers.corpus import foreign_fmus, imperfect

pytestmark = [
    pytest.mark.peers,
    pytest.mark.skipif(
        sys.platform != "linux" or platform.machine() != "x86_64", reason="built for Linux x86-64"
    ),
]
TICKS = 40
LEAST_EQUAL, LEAST_NOTED = 60, 25
MADE_IMPERFECT = 14
"""So many of those without a fault are given one, beside those that have their own."""


def compare(path: Path, folder: Path) -> tuple[str, bool]:
    """What differs (empty where nothing does), and whether rules of the standard are broken."""
    description = read_description(path)
    step = description.step_size or Fraction(1, 100)
    out, there = folder / "out", folder / "there.npz"
    command = [sys.executable, "-c", "from cosim.cli import main; main()", "run", str(path)]
    options = ["--stop-time", str(step * TICKS), "--step-size", str(step), "--no-figure"]
    if description.start_time:  # the loop of FMPy's calls begins at 0
        options += ["--set", "start_time=0"]
    ours = subprocess.run(
        [*command, *options, "--out", str(out)], capture_output=True, text=True, check=False
    )
    numbers = [str(step.numerator), str(step.denominator), str(TICKS)]
    loop = [sys.executable, "-m", "tests.support.peers.reference_loop", str(path)]
    theirs = subprocess.run(
        [*loop, *numbers, str(there)], capture_output=True, text=True, check=False
    )
    is_noted = bool(description.breaks)
    if theirs.returncode or not there.is_file():
        return (
            "" if ours.returncode else "FMPy cannot run it, and we can"
        ) or f"neither runs it: {ours.stderr[-300:]} / {theirs.stderr[-200:]}", is_noted
    if not out.is_dir():
        return f"FMPy runs it, and we cannot: {ours.stderr[-300:]}", is_noted
    return different(out, there), is_noted


def different(out: Path, there: Path) -> str:
    expected = np.load(there)
    name = json.loads((out / "manifest.json").read_text())["scenario"]["name"]
    with open_run(out) as run:
        for variable in expected.files:
            actual = np.asarray(run[f"{name}.{variable}"].values)
            stated = expected[variable].astype(actual.dtype)
            rows = min(len(actual), len(stated))
            if rows == 0 or len(actual) != len(stated):
                return f"{variable}: {len(actual)} rows here, {len(stated)} there"
            if actual.tobytes() != stated.tobytes():
                first = int(np.argmax(actual != stated))
                return f"{variable}: {actual[first]!r} here, {stated[first]!r} there at {first}"
    return ""


def test_sixty_are_equal_and_twenty_five_imperfect_ones_run(
    tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    found: dict[str, tuple[str, bool]] = {}
    (tmp_path / "made").mkdir()
    for number, path in enumerate(foreign_fmus(tmp_path / "made")):
        folder = tmp_path / str(number)
        folder.mkdir()
        given = path
        if number < MADE_IMPERFECT:
            given = imperfect(path, folder / path.name)
        found[f"{number} {path.name}"] = compare(given, folder)
    bad = {name: what for name, (what, _) in found.items() if what}
    equal = len(found) - len(bad)
    noted = sum(is_noted for what, is_noted in found.values() if not what)
    record_property("equal", equal)
    record_property("noted", noted)
    sentence = f"{equal} equal, {noted} of them with notes; not: {json.dumps(bad, indent=1)}"
    assert equal >= LEAST_EQUAL, sentence
    assert noted >= LEAST_NOTED, sentence
