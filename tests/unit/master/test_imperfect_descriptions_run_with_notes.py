"""A description that breaks rules of the standard runs with a note, or is refused when strict."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

U = {version: scalar(version, "u", 1, causality="input", start="0") for version in (2, 3)}
IMPERFECT = {
    "an element out of place": {"before": "<Vendor/>"},
    "a start that is missing": {"more": {"causality": "input"}},
}


def imperfect(folder: Path, version: int, how: str) -> Path:
    given = dict(IMPERFECT[how])
    more = given.pop("more", None)
    variables = U[version] + (scalar(version, "v", 2, **more) if more else "")
    return foreign_fmu(folder, version, variables, **given)


def scenario(fmu: Path, more: str = "") -> str:
    component = f"{{fmu: {fmu}, rate: 1{more}}}"
    return f"duration: 2\nbase_rate: 1\ncomponents:\n  f: {component}\nrecord: [f.u]\n"


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("how", IMPERFECT)
def test_it_runs_and_says_so(tmp_path: Path, version: int, how: str) -> None:
    fmu = imperfect(tmp_path, version, how)
    sink, simulation = run(scenario_of(tmp_path, scenario(fmu)))
    assert sink.signal("f.u").tolist() == [0.0, 0.0]
    (note,) = simulation.notes
    assert note.startswith("f: its modelDescription.xml is not valid: ")


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("how", IMPERFECT)
def test_strict_refuses_what_lenient_notes(tmp_path: Path, version: int, how: str) -> None:
    fmu = imperfect(tmp_path, version, how)
    with assemble(scenario_of(tmp_path, scenario(fmu))) as simulation:
        assert "is not valid" in simulation.notes[0]
    with pytest.raises(InputError, match="is not valid"):
        assemble(scenario_of(tmp_path, scenario(fmu, ", validate: strict")))


@pytest.mark.parametrize("has_resources", [False, True])
def test_the_path_of_resources_is_null_where_there_are_none(
    tmp_path: Path, has_resources: bool
) -> None:
    refuses = "m->resources == 0" if has_resources else "m->resources != 0"
    snippet = f"""
        static int hook(Foreign *m, const char *call)
        {{
            return is(call, "Instantiate") && {refuses};
        }}
        #define HOOK hook
    """
    extra = {"resources/table.txt": "1"} if has_resources else {}
    run(
        scenario_of(
            tmp_path, scenario(foreign_fmu(tmp_path, 3, U[3], snippet=snippet, extra=extra))
        )
    )


def test_validation_belongs_to_fmus(tmp_path: Path) -> None:
    written = "duration: 1\ncomponents:\n  f: {python: 'a:B', rate: 1, validate: strict}\n"
    with pytest.raises(InputError, match="'validate' belongs to 'fmu', not to 'python'"):
        scenario_of(tmp_path, written)


def test_a_name_that_is_there_twice_is_refused(tmp_path: Path) -> None:
    fmu = foreign_fmu(tmp_path, 3, U[3] + U[3])
    with pytest.raises(InputError, match="declares u twice"):
        assemble(scenario_of(tmp_path, scenario(fmu)))


@pytest.mark.parametrize("version", [2, 3])
def test_an_index_may_be_a_word(tmp_path: Path, version: int) -> None:
    fixed = {"causality": "parameter", "variability": "fixed", "start": "1"}
    variables = U[version] + scalar(version, "p[Color.red]", 2, **fixed)
    fmu = foreign_fmu(tmp_path, version, variables)
    run(scenario_of(tmp_path, scenario(fmu, ", parameters: {'p[Color.red]': 3}")))
    with pytest.raises(InputError, match="f has no parameter 'p'"):
        assemble(scenario_of(tmp_path, scenario(fmu, ", parameters: {p: [3]}")))
