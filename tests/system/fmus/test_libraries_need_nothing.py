"""Every library exports all FMI functions, nothing else, and needs nothing that may be missing."""

from __future__ import annotations

import ctypes
import zipfile
from pathlib import Path

import pytest

from fmus.builder import FOLDER, Source, build_fmus
from fmus.compiler import BuildError, host_platform
from fmus.symbols import fmi_functions, problems_of, symbols_of
from fmus.table import Model, ModelVariable
from tests.support.fmus import fmu_support as support

REQUIRED = fmi_functions(FOLDER / "fmi" / "headers")


def libraries(name: str) -> dict[str, bytes]:
    with zipfile.ZipFile(support.path_of(name)) as archive:
        names = [entry for entry in archive.namelist() if entry.startswith("binaries/")]
        return {entry.split("/")[1]: archive.read(entry) for entry in names}


def test_the_headers_name_every_function() -> None:
    assert len([name for name in REQUIRED if name.startswith("fmi2")]) == 44
    assert len([name for name in REQUIRED if name.startswith("fmi3")]) == 75


@pytest.mark.parametrize("name", support.MODELS)
def test_symbols_on_every_platform(name: str) -> None:
    for platform, image in libraries(name).items():
        assert problems_of(image, platform, REQUIRED) == [], platform


def test_a_linux_library_loads_no_other_library() -> None:
    for platform, image in libraries("hand").items():
        if platform.endswith("linux"):
            assert symbols_of(image).libraries == frozenset()
            assert symbols_of(image).needed == frozenset()


def test_the_dynamic_loader_finds_what_the_table_says(tmp_path: Path) -> None:
    platform = host_platform()
    path = tmp_path / f"hand{platform.suffix}"
    path.write_bytes(libraries("hand")[platform.name])
    library = ctypes.CDLL(str(path))
    for name in REQUIRED:
        assert getattr(library, name)
    library.fmi2GetVersion.restype = library.fmi3GetVersion.restype = ctypes.c_char_p
    assert library.fmi2GetVersion() == b"2.0"
    assert library.fmi3GetVersion() == b"3.0"


def test_a_model_that_calls_the_c_library_is_not_built(tmp_path: Path) -> None:
    (tmp_path / "variables.py").touch()
    (tmp_path / "model.c").write_text(
        '#include "leaky_variables.h"\n'
        "int rand(void);\n"
        "struct State { int x; };\n"
        "const size_t model_state_size = sizeof(State);\n"
        "const char *model_initialise(Variables *v, State *s, Report *r) { return NULL; }\n"
        "void model_outputs(Variables *v, const State *s) { v->y = rand(); }\n"
        "const char *model_step(Variables *v, State *s, double t, double h, Report *r)\n"
        "{ return NULL; }\n"
    )
    output = ModelVariable(name="y", description="y", causality="output", unit="1")
    model = Model(name="leaky", description="", variables=(output,), sources=("model.c",))
    with pytest.raises(BuildError, match="rand"):
        build_fmus(Source(model, tmp_path), platforms=[host_platform()], output=tmp_path / "out")
