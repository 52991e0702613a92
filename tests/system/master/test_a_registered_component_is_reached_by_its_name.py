"""A package that is installed beside cohaptic registers a component under a short name."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from cosim.base.errors import InputError
from tests.support.installed_package import install
from tests.support.master.master_support import scenario_of

PROJECT = """
[project]
name = "lab-parts"
version = "1.0"
[project.entry-points."cohaptic.components"]
lab-counter = "lab_parts:Counter"
"""


def written(name: str) -> dict[str, object]:
    part = {"python": name, "rate": 64}
    return {"duration": 0.25, "components": {"it": part}, "record": ["it.*"]}


def test_it_runs_as_any_other(tmp_path: Path) -> None:
    package = tmp_path / "package"
    (package / "lab_parts").mkdir(parents=True)
    (package / "pyproject.toml").write_text(PROJECT)
    (package / "lab_parts" / "__init__.py").write_text(
        "from tests.support.master.text_parts import Counter\n"
    )
    environment = install(package, tmp_path / "installed")
    (tmp_path / "it.yaml").write_text(json.dumps({"cohaptic": 1, **written("lab-counter")}))

    def cohaptic(*arguments: str) -> subprocess.CompletedProcess[str]:
        call = [sys.executable, "-c", "from cosim.cli import main; main()", *arguments]
        return subprocess.run(
            call, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False
        )

    done = cohaptic("run", "it.yaml", "--out", "run", "--no-figure")
    assert done.returncode == 0, done.stderr
    listed = json.loads(cohaptic("record", "list", "run", "--json").stdout)
    assert set(listed["groups"]["64Hz"]["texts"]) >= {"it.word", "it.data"}
    (tmp_path / "it.yaml").write_text(json.dumps({"cohaptic": 1, **written("lab-conter")}))
    refused = cohaptic("check", "it.yaml")
    assert refused.returncode == 2
    assert "lab-counter" in refused.stderr


def test_a_name_that_nobody_registered_is_refused_with_its_place(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'nobody' is no Python class.*has registered") as caught:
        scenario_of(tmp_path, written("nobody"))
    assert "test.yaml:1:" in str(caught.value)
