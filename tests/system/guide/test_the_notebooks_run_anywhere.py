"""The notebooks run in Jupyter, and from the wheel in an empty folder on every Python it is for."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.support.guide.notebooks import FOLDER, cells_of, executed, files

ROOT = Path(__file__).parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
NAMED = (re.search(r"Python :: (3\.\d+)$", line) for line in PROJECT["classifiers"])
VERSIONS = [found[1] for found in NAMED if found]
WANTED = os.environ.get("WHEEL_PYTHON")
"""The version that a lane is for: there it is, or the lane fails; ``all``: those that are here."""


def test_every_notebook_is_on_the_site() -> None:
    assert sorted(files()) == sorted(FOLDER.glob("*.py"))
    nav = (ROOT / "mkdocs.yml").read_text("utf-8")
    for file in files():
        assert f"notebooks/{file.stem}.md" in nav
        assert {kind for kind, _ in cells_of(file)} == {"markdown", "code"}


def test_the_versions_are_the_same_wherever_they_stand() -> None:
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text("utf-8")
    matrix = re.search(r"python: \[(.*)\]", workflow)
    assert matrix is not None
    assert re.findall(r"3\.\d+", matrix[1]) == VERSIONS
    assert PROJECT["requires-python"] == f">={VERSIONS[0]}"


@pytest.mark.slow
@pytest.mark.parametrize("file", files(), ids=lambda file: file.stem)
def test_jupyter_runs_it(file: Path, tmp_path: Path) -> None:
    jupytext = pytest.importorskip("jupytext")
    nbclient = pytest.importorskip("nbclient")
    notebook = jupytext.read(file)
    assert [cell.cell_type for cell in notebook.cells] == [kind for kind, _ in cells_of(file)]
    nbclient.NotebookClient(
        notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}
    ).execute()


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("wheel")
    subprocess.run(["uv", "build", "-q", "--wheel", "-o", str(out), str(ROOT)], check=True)
    return next(out.glob("*.whl"))


def interpreter(version: str) -> str | None:
    """Of this version, wherever it is installed."""
    if sys.version_info[:2] == tuple(map(int, version.split("."))):
        return sys.executable
    found = sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python"))
    return str(found[-1]) if found else shutil.which(f"python{version}")


@pytest.mark.slow
@pytest.mark.parametrize("version", VERSIONS)
def test_the_wheel_has_all_that_a_new_user_needs(version: str, wheel: Path, tmp_path: Path) -> None:
    base = interpreter(version)
    if WANTED not in {version, "all"}:
        pytest.skip("WHEEL_PYTHON names the version")
    if base is None:
        assert WANTED == "all"
        pytest.skip(f"no Python {version} here; the workflow has it")
    python = tmp_path / "venv" / "bin" / "python"
    quiet = {"check": True, "cwd": tmp_path}
    subprocess.run(["uv", "venv", "-q", "--python", base, str(tmp_path / "venv")], **quiet)
    given = [f"{wheel}[notebook]", "--python", str(python)]
    subprocess.run(["uv", "pip", "install", "-q", *given], **quiet)
    # From a copy: nothing of the checkout is near.
    copies = [shutil.copy(file, tmp_path) for file in files()]
    for file in copies:
        assert any(cell["output"] for cell in executed(Path(file), str(python)))
    asked = {"_COHAPTIC_COMPLETE": "bash_complete"}
    asked |= {"COMP_WORDS": "cohaptic run two_u", "COMP_CWORD": "2"}
    told = subprocess.run(
        [str(python.with_name("cohaptic"))],
        env={**os.environ, **asked},
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert "two_users_box" in told.stdout
