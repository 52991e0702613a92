"""A formal model of the standard's rules finds nothing in any of our FMUs.

Clone https://github.com/INTO-CPS-Association/FMI-VDM-Model and, at its tag ``4.5.0-release``,
https://github.com/nickbattle/vdmj into one folder; then
``COHAPTIC_VDMCHECK=folder uv run pytest -m peers tests/peers/test_vdmcheck_finds_nothing.py``.
A Java compiler is needed.
"""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import pytest

import fmus
from fmus.archive import FLAVOURS
from tests.support.fmus import fmu_support as support
from tests.support.peers.vdmcheck import VdmCheck

SOURCES = Path(os.environ.get("COHAPTIC_VDMCHECK", "vdmcheck"))
pytestmark = [
    pytest.mark.peers,
    pytest.mark.skipif(shutil.which("javac") is None, reason="there is no Java compiler"),
    pytest.mark.skipif(
        not (SOURCES / "FMI-VDM-Model").is_dir() or not (SOURCES / "vdmj").is_dir(),
        reason="COHAPTIC_VDMCHECK is no folder with both sources",
    ),
]


@pytest.fixture(scope="module")
def check(tmp_path_factory: pytest.TempPathFactory) -> VdmCheck:
    sources = SOURCES.resolve()
    folder = tmp_path_factory.mktemp("vdmcheck")
    return VdmCheck(sources / "FMI-VDM-Model", sources / "vdmj", folder)


@pytest.mark.parametrize("flavour", FLAVOURS)
@pytest.mark.parametrize("name", support.MODELS)
def test_no_rule_is_broken(name: str, flavour: str, check: VdmCheck) -> None:
    version = 2 if flavour == "fmi2" else 3
    assert check.judge(fmus.find(name, flavour), version) == "true"


@pytest.mark.parametrize(
    ("flavour", "old", "new"),
    [
        ("fmi2", r'causality="output" (variability="continuous")', r'causality="parameter" \1'),
        ("fmi3", r'<Output valueReference="\d+"', '<Output valueReference="9999"'),
        ("fmi3", r'(<Annotation type="[^"]*">)', r"\1text"),
    ],
)
def test_a_broken_rule_is_found(
    flavour: str, old: str, new: str, check: VdmCheck, tmp_path: Path
) -> None:
    version = 2 if flavour == "fmi2" else 3
    shutil.unpack_archive(fmus.find("pantograph", flavour), tmp_path, "zip")
    description = tmp_path / "modelDescription.xml"
    text, count = re.subn(old, new, description.read_text())
    assert count > 0
    description.write_text(text)
    assert check.judge(description, version) != "true"
