"""The wheel is for any platform, brings FMUs and kernel, and works outside the checkout."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from cosim.record.reader import open_run
from fmus.archive import FLAVOURS
from fmus.builder import FOLDER
from fmus.compiler import PLATFORMS
from tests.support.fmus import fmu_support as support

SCENARIOS = FOLDER.parent / "scenarios"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    uv = shutil.which("uv")
    if uv is None:
        pytest.skip("needs uv")
    command = [uv, "build", "--wheel", "-o", str(folder), str(FOLDER.parent)]
    subprocess.run(command, check=True, capture_output=True)
    return next(folder.glob("*.whl"))


def test_it_holds_what_was_compiled_and_no_probes(wheel: Path) -> None:
    assert wheel.name.endswith("-py3-none-any.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    for model in support.MODELS:
        for flavour in FLAVOURS:
            assert f"fmus/_built/{model}.{flavour}.fmu" in names
    for platform in PLATFORMS:
        assert any(f"kernel-{platform.name}-" in name for name in names)
    unwanted = ("fmus/probe", "fmus/_built/development", "fmus/_built/probe")
    assert not [name for name in names if name.startswith(unwanted)]


def test_it_works_outside_the_checkout(wheel: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    program = "import fmus; print(fmus.is_checkout(), fmus.find('pantograph', 'fmi2'))"
    result = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path / "site")},
        capture_output=True,
        text=True,
        check=True,
    )
    place = tmp_path / "site" / "fmus" / "_built" / "pantograph.fmi2.fmu"
    assert result.stdout.split() == ["False", str(place)]


def test_a_model_of_ones_own_is_built_judged_and_run_with_it(wheel: Path, tmp_path: Path) -> None:
    """In an empty folder, where there is no checkout; also as the folder of an unpacked archive."""
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    here = tmp_path / "empty"
    here.mkdir()

    def cohaptic(*words: str) -> str:
        done = subprocess.run(
            [sys.executable, "-c", "from cosim.cli import main; main()", *words],
            cwd=here,
            env=os.environ | {"PYTHONPATH": str(tmp_path / "site")},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    cohaptic("fmu", "new", "ball")
    cohaptic("fmu", "build", "ball", "--out", "made")
    assert "starts and ends" in cohaptic("fmu", "validate", "made/ball.fmi3.fmu")
    with zipfile.ZipFile(here / "made" / "ball.fmi2.fmu") as archive:
        archive.extractall(here / "unpacked")
    found = []
    for given in ("made/ball.fmi2.fmu", "unpacked"):
        cohaptic("run", given, "--stop-time", "1", "--out", f"run{len(found)}", "--no-figure")
        with open_run(here / f"run{len(found)}") as run:
            found.append([signal.values.tolist() for signal in run.signals.values()])
    assert found[0] == found[1]
    assert found[0]


def test_it_installs_one_public_package_and_brings_the_scenarios(
    wheel: Path, tmp_path: Path
) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    tops = {name.partition("/")[0] for name in names if not name.startswith("cohaptic-")}
    assert tops == {"cohaptic", "cosim", "fmus", "hil"}
    assert "cohaptic/py.typed" in names
    modules = {
        file.relative_to(FOLDER.parent).as_posix()
        for top in tops
        for file in (FOLDER.parent / top).rglob("*.py")
        if not {"_built", "probe"} & set(file.parts)
    }
    assert modules <= set(names)
    written = {file.relative_to(SCENARIOS).as_posix() for file in SCENARIOS.rglob("*.yaml")}
    assert {f"cohaptic/_scenarios/{name}" for name in written} <= set(names)


def test_a_scenario_runs_where_the_wheel_is_installed(wheel: Path, tmp_path: Path) -> None:
    uv = shutil.which("uv")
    assert uv is not None
    place = tmp_path / "venv"
    subprocess.run([uv, "venv", "-q", str(place)], check=True)
    python = place / ("Scripts" if os.name == "nt" else "bin") / "python"
    subprocess.run([uv, "pip", "install", "-q", "--python", str(python), str(wheel)], check=True)
    (tmp_path / "scenarios").mkdir()  # not ours, and not to be found
    command = [*(str(python.parent / "cohaptic"), "run", "two_users_box", "--set", "duration=0.2")]
    subprocess.run(
        [*command, "--set", "expect=~", "--out", "r", "--no-figure"], cwd=tmp_path, check=True
    )
    assert (tmp_path / "r" / "run.h5").is_file()
    program = "import cohaptic; print(cohaptic.load('scenarios/single_user.yaml').file)"
    found = subprocess.run(
        [str(python), "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert "cohaptic/_scenarios/single_user.yaml" in Path(found.stdout.strip()).as_posix()
