"""Every model, and the kernel with every bundled scenario, under valgrind.

Sanitizers watch addresses and what C leaves undefined; valgrind knows of every bit whether it was
ever written. A state in which some were not is another one in every run.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.fmus import watched
from tests.support.fmus.hosted import NAMES, model_program, shared_objects
from tests.support.fmus.valgrind import VALGRIND, complaints

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or VALGRIND is None, reason="valgrind has to be installed"
)
COMPILER = ("gcc",)
HOUSE = Path(__file__).parents[3]
WRONG = """#include <stdlib.h>
int wrong(int how)
{
    int *never = malloc(8);
    if (how == 1) return never[1] ? 1 : 2;
    if (how == 2) return never[2] = 3;
    free(never);
    return 0;
}
"""


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return shared_objects(COMPILER, tmp_path_factory.mktemp("objects"))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", NAMES)
def test_a_model_uses_nothing_unwritten(name: str, objects: list[Path], tmp_path: Path) -> None:
    """A life with saved states, and one in which no call keeps a rule."""
    for main in ("hostile.c", "exercise.c"):
        folder = tmp_path / main
        folder.mkdir()
        program = model_program(COMPILER, main, name, objects, folder)
        found, done = complaints([program, "12"], folder, leaks=True)
        assert found == []
        assert (done.returncode, int(done.stdout) > 0) == (0, True), done.stderr


@pytest.mark.exhaustive
def test_every_bundled_scenario(tmp_path: Path) -> None:
    watched.build(tmp_path)
    command = [sys.executable, "-m", "tests.support.fmus.watched", tmp_path]
    found, done = complaints(command, tmp_path, cwd=HOUSE)
    assert found == []
    assert done.returncode == 0, done.stderr[-4000:]
    assert len(done.stdout.split()) >= 28


@pytest.mark.slow
@pytest.mark.parametrize(
    ("how", "said"), [(0, ""), (1, "uninitialised value"), (2, "Invalid write of size 4")]
)
def test_valgrind_sees_through_python(how: int, said: str, tmp_path: Path) -> None:
    """What a library does that Python has loaded."""
    source, library = tmp_path / "wrong.c", tmp_path / "wrong.so"
    source.write_text(WRONG)
    subprocess.run(["gcc", "-g", "-fPIC", "-shared", source, "-o", library], check=True)
    call = f"import ctypes; ctypes.CDLL({str(library)!r}).wrong({how})"
    found, _ = complaints([sys.executable, "-S", "-c", call], tmp_path)
    if said:
        assert any(said in sentence and "wrong (wrong.c:" in sentence for sentence in found)
    else:
        assert found == []
