"""An FMU that promises to give its state away, and then does not: a sentence, never a crash.

Its library lacks a function, refuses, says that all is well and hands out nothing, or names a size
that no memory has. In the process of the run and in one of its own, FMI 2 and 3.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from cosim.analysis.monodromy.run_map import RunMap
from cosim.base.errors import InputError, RunError
from cosim.base.recording import MemorySink
from cosim.master.fmu.state import FMI2, FMI3, StateFunctions
from cosim.master.run.simulation import Simulation, assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import scenario_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the snippets are POSIX's")
FUNCTIONS = {2: FMI2, 3: FMI3}
BODIES = {
    "get": "(Foreign *m, void **state) { kept = *m; *state = &kept; return 0; }",
    "set": "(Foreign *m, void *state) { return *(char *)state & 0; }",
    "free": "(Foreign *m, void **state) { *state = 0; return 0; }",
    "size": "(Foreign *m, void *state, size_t *size) { *size = 16; return 0; }",
    "serialise": "(Foreign *m, void *state, char *bytes, size_t size) { return bytes[0] & 0; }",
    "deserialise": "(Foreign *m, const char *bytes, size_t size, void **state)"
    " { kept = *m; *state = &kept; return 0; }",
}
"""Of every function of the standard, well done."""
LIES = {
    "no state is handed out": (
        "get",
        "(Foreign *m, void **state) { return 0; }",
        "handed out no state",
    ),
    "none is made of bytes": (
        "deserialise",
        "(Foreign *m, const char *bytes, size_t size, void **state) { return 0; }",
        "handed out no state",
    ),
    "a size never set": (
        "size",
        "(Foreign *m, void *state, size_t *size) { *size = (size_t)-1; return 0; }",
        f"says that its state has {2**64 - 1} bytes",
    ),
    "a size of no memory": (
        "size",
        "(Foreign *m, void *state, size_t *size) { *size = (size_t)1 << 46; return 0; }",
        f"says that its state has {2**46} bytes",
    ),
}
"""Which function says that all is well, what it does, and what is said of it."""


def library(version: int, changed: dict[str, str | None]) -> str:
    """The functions of a version in C, some of them with another body or none at all."""
    bodies = {**BODIES, **changed}
    lines = ["static Foreign kept;"]
    for role, body in bodies.items():
        if body is not None:
            name = getattr(FUNCTIONS[version], role)
            lines.append(f"EXPORT int {name}{body}")
    return "\n".join(lines)


@dataclass(frozen=True)
class Made:
    simulation: Callable[[], Simulation]
    functions: StateFunctions


def made(folder: Path, version: int, changed: dict[str, str | None], *, isolated: bool) -> Made:
    capital = "State" if version == 3 else "state"
    fmu = foreign_fmu(
        folder,
        version,
        scalar(version, "u", 1, causality="input", start="0"),
        snippet=library(version, changed),
        interface={f"canGetAndSetFMU{capital}": "true", f"canSerializeFMU{capital}": "true"},
    )
    box = {"fmu": str(fmu), "rate": 100} | ({"isolate": "process"} if isolated else {})
    written = {"duration": 0.05, "components": {"box": box}}
    return Made(lambda: assemble(scenario_of(folder, written)), FUNCTIONS[version])


def saves_and_loads(this: Made) -> None:
    with this.simulation() as simulation:
        simulation.start()
        simulation.advance(2)
        snapshot = simulation.snapshot()
        simulation.advance(4)
        simulation.restore(snapshot)
        simulation.advance(5)


def keeps_and_goes_back(this: Made) -> None:
    with this.simulation() as simulation:
        simulation.run(MemorySink(), until=2, keep_fmus=True, mark_at_end=True)
        simulation.branch(simulation.assembly)
        simulation.run(MemorySink())


USES = {"as bytes": saves_and_loads, "kept": keeps_and_goes_back}
PLACES = [(2, False), (3, False), (3, True)]


@pytest.mark.parametrize(("version", "isolated"), PLACES)
@pytest.mark.parametrize("use", USES)
def test_one_that_keeps_its_word_is_used(
    tmp_path: Path, version: int, use: str, isolated: bool
) -> None:
    USES[use](made(tmp_path, version, {}, isolated=isolated))


@pytest.mark.parametrize(("version", "isolated"), PLACES)
@pytest.mark.parametrize("lacking", [("set", "free"), tuple(BODIES)])
@pytest.mark.parametrize("use", USES)
def test_functions_that_the_library_lacks_are_named(
    tmp_path: Path, version: int, use: str, lacking: tuple[str, ...], isolated: bool
) -> None:
    this = made(tmp_path, version, dict.fromkeys(lacking), isolated=isolated)
    with pytest.raises(RunError) as caught:
        USES[use](this)
    said = str(caught.value)
    assert said.startswith("box: the FMU foreign.fmu says that its state can be saved, but")
    for role in lacking:
        assert getattr(this.functions, role) in said


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("status", [2, 3])
@pytest.mark.parametrize("role", BODIES)
def test_a_refusal_is_told_with_its_status(
    tmp_path: Path, version: int, role: str, status: int
) -> None:
    head = BODIES[role].partition(" {")[0]
    this = made(tmp_path, version, {role: f"{head} {{ return {status}; }}"}, isolated=False)
    word = {2: "discard", 3: "error"}[status]
    does = "restore" if role in {"set", "deserialise"} else "save"
    with pytest.raises(RunError, match=rf"box: the FMU cannot {does} its state .*status {word}\)"):
        saves_and_loads(this)


@pytest.mark.parametrize(("version", "isolated"), PLACES)
@pytest.mark.parametrize("lie", LIES)
def test_what_is_called_well_and_is_not_is_told(
    tmp_path: Path, version: int, lie: str, isolated: bool
) -> None:
    role, body, said = LIES[lie]
    this = made(tmp_path, version, {role: body}, isolated=isolated)
    function = getattr(this.functions, role)
    with pytest.raises(RunError, match=rf"box: .*{function} .*{said}") as caught:
        saves_and_loads(this)
    assert "at tick" in str(caught.value)


@pytest.mark.parametrize("size", [0, 5, 16])
def test_the_theory_of_a_run_refuses_a_state_that_is_not_ours(tmp_path: Path, size: int) -> None:
    body = f"(Foreign *m, void *state, size_t *size) {{ *size = {size}; return 0; }}"
    changed = {
        "size": body,
        "serialise": "(Foreign *m, void *s, char *b, size_t n) {{ return 0; }}",
    }
    this = made(tmp_path, 3, changed, isolated=False)
    with this.simulation() as simulation:
        simulation.start()
        with pytest.raises(InputError, match="moves the state of its parts, and cannot for box: "):
            RunMap(simulation)
