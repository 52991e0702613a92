"""An FMU that prints to stdout does not spoil ``--json``: only the answer is there."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import fmus.probe
from fmus import builder
from fmus.builder import Source, build_fmus
from fmus.compiler import host_platform

PRINTING = """
int printf(const char *, ...);
__attribute__((constructor)) static void loaded(void) { printf("the library is loaded\\n"); }
__attribute__((destructor)) static void unloaded(void) { printf("the library goes\\n"); }
"""


@pytest.fixture
def talkative(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """``probe_tick`` with a C library of the process's own to print with."""
    source = fmus.probe.source_of("probe_tick")
    model = replace(source.model, name="talkative")
    text = (source.folder / "model.c").read_text().replace("probe_tick_", "talkative_")
    said = '    ++s->steps;\n    printf("printed step %d\\n", (int)s->steps);\n'
    assert "    ++s->steps;\n" in text
    (tmp_path / "variables.py").touch()
    (tmp_path / "model.c").write_text(PRINTING + text.replace("    ++s->steps;\n", said))
    monkeypatch.setattr(builder, "problems_of", lambda *_: [])  # printf is not on the list
    build_fmus(Source(model, tmp_path), platforms=[host_platform()], output=tmp_path)
    return tmp_path / "talkative.fmi3.fmu"


@pytest.mark.skipif(sys.platform != "linux", reason="a library may lack symbols on Linux only")
@pytest.mark.parametrize("as_json", [True, False])
def test_stdout_has_the_summary_and_nothing_else(
    talkative: Path, tmp_path: Path, as_json: bool
) -> None:
    scenario = tmp_path / "talk.yaml"
    component = f"{{fmu: {talkative}, rate: 10}}"
    scenario.write_text(f"cohaptic: 1\nduration: 1\ncomponents:\n  talk: {component}\n")
    done = subprocess.run(
        [
            *(sys.executable, "-c", "from cosim.cli import main; main()", "run", str(scenario)),
            *("--no-figure", *(["--json"] if as_json else [])),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    if as_json:
        assert json.loads(done.stdout)["ticks"] == 10
    assert "printed step" not in done.stdout
    assert "the library" not in done.stdout
    assert done.stderr.count("printed step ") == 10
    assert "the library is loaded" in done.stderr


def test_stdout_works_where_there_is_no_stderr() -> None:
    code = "import os; os.close(2)\nfrom cosim.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, "--version"], stdout=subprocess.PIPE, text=True, check=True
    )
    assert "version" in done.stdout
