"""GitHub's workflow runs what .ci/run does, on every Python, with actions that nobody can move."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[3]
FILES = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def workflow() -> dict[str, Any]:
    (file,) = FILES
    return yaml.safe_load(file.read_text("utf-8"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_every_action_is_pinned_to_a_commit(file: Path) -> None:
    """A tag can be moved to other code; the comment says which version the commit was."""
    used = re.findall(r"uses: *(.*)", file.read_text("utf-8"))
    assert used
    for action in used:
        assert re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40} +# v\d+\.\d+\.\d+", action), action


def test_a_job_runs_the_whole_of_ci_and_none_may_write() -> None:
    found = workflow()
    assert found["permissions"] == {"contents": "read"}
    assert [step["run"] for step in found["jobs"]["test"]["steps"] if "run" in step] == [".ci/run"]
    assert all(job["timeout-minutes"] <= 90 for job in found["jobs"].values())


def test_each_python_has_the_wheel_of_its_own() -> None:
    job = workflow()["jobs"]["wheel"]
    assert job["strategy"]["matrix"]["python"] == ["3.11", "3.12", "3.13", "3.14"]
    assert job["strategy"]["fail-fast"] is False
    (last,) = [step["run"] for step in job["steps"] if "pytest" in step.get("run", "")]
    assert last.startswith("WHEEL_PYTHON=${{ matrix.python }} ")
    lane = "tests/system/guide/test_the_notebooks_run_anywhere.py"
    assert lane in last
    assert (ROOT / lane).is_file()


def test_what_ci_installs_it_installs_as_whoever_runs_it() -> None:
    """A runner of GitHub's is no root."""
    script = (ROOT / ".ci" / "run").read_text("utf-8")
    assert re.findall(r"^.*apt-get.*$", script, re.M) == re.findall(
        r'^    "\$\{as_root\[@\]\}" apt-get .*$', script, re.M
    )
