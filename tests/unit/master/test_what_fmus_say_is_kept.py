"""Warnings and errors of FMUs are in ``fmu.log``, each text once; a model may end the run well."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.run import LOG_FILE, run_scenario
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import scenario_of

SAYS = """
    static int hook(Foreign *m, const char *call)
    {
        if (!is(call, "DoStep"))
            return 0;
        say(m, 0, "all is well");
        say(m, 1, "it is warm");
        m->terminate = %d && m->time >= 3;
        return 1 - m->terminate;
    }
    #define HOOK hook
"""


def scenario(folder: Path, version: int, *, ends: bool) -> str:
    variables = scalar(version, "u", 1, causality="input", start="2")
    fmu = foreign_fmu(folder, version, variables, snippet=SAYS % ends)
    return f"duration: 8\nbase_rate: 1\ncomponents:\n  f: {{fmu: {fmu}, rate: 1}}\nrecord: [f.u]\n"


@pytest.mark.parametrize("version", [2, 3])
def test_warnings_are_kept_once_with_their_count_and_chatter_is_not(
    tmp_path: Path, version: int
) -> None:
    written = scenario_of(tmp_path, scenario(tmp_path, version, ends=False))
    finished = run_scenario(written, tmp_path / "out", figure=False)
    assert finished.summary.content["warnings"] == {"f": 8}
    assert (finished.folder / LOG_FILE).read_text() == "f: warning: it is warm (8 times)\n"


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(("limit", "status"), [(3, 0), (1, 1)])
def test_the_end_that_a_model_asks_for_is_good_and_expectations_are_judged(
    tmp_path: Path, version: int, limit: int, status: int
) -> None:
    text = scenario(tmp_path, version, ends=True)
    judged = f"expect:\n  f.u: {{max_abs_below: {limit}}}\n"
    written = scenario_of(tmp_path, text + judged)
    finished = run_scenario(written, tmp_path / "out", figure=False)
    content = finished.summary.content
    assert content["status"] == status
    assert content["ticks"] == 4
    assert content["message"].startswith("f asked to end the simulation at tick 3 (3 s)")


COUNTS = """
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "DoStep")) {
            m->real[2] += 1;
            m->terminate = m->time >= 3;
        }
        return 0;
    }
    #define HOOK hook
"""


@pytest.mark.parametrize("version", [2, 3])
def test_the_last_outputs_before_the_end_that_a_model_asks_for_are_kept(
    tmp_path: Path, version: int
) -> None:
    structure = {
        2: '<Outputs><Unknown index="1" dependencies=""/></Outputs>',
        3: '<Output valueReference="2" dependencies=""/>',
    }
    fmu = foreign_fmu(
        tmp_path,
        version,
        scalar(version, "y", 2, causality="output"),
        snippet=COUNTS,
        structure=structure[version],
    )
    written = scenario_of(
        tmp_path,
        f"duration: 8\nbase_rate: 1\ncomponents: {{f: {{fmu: {fmu}, rate: 1}}}}\nrecord: [f.y]\n",
    )
    finished = run_scenario(written, tmp_path / "out", figure=False)
    with finished.open() as record:
        assert record["f.y"].values.tolist() == [0, 1, 2, 3]
