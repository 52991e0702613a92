"""Logging is on, the categories of what went wrong are chosen, and `fmu.log` has it by its status.

In the process of the run and in one of its own, paced or not.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from cosim.cli.support.run.one import RunOptions, read_one, run_one
from cosim.run import LOG_FILE
from tests.support.fmus.failing import PLACES
from tests.support.fmus.foreign import foreign_fmu, scalar

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="a child needs Linux")

TELLS = """
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "Terminate"))
            say(m, 1, "that was all");
        if (is(call, "FreeInstance"))
            say(m, 1, "free at last");
        if (!is(call, "DoStep"))
            return 0;
        say(m, 0, "all is well");
        say(m, 1, m->logging ? "it is on" : "it is off");
        say(m, 1, m->categories[0] ? m->categories : "no categories");
        return 0;
    }
    #define HOOK hook
"""
OF_THE_STANDARD = {
    2: ("logAll", "logStatusWarning", "logEvents", "logStatusDiscard", "logStatusError"),
    3: ("logEvents", "logStatusWarning", "logStatusError", "logStatusFatal"),
}
CHOSEN = {
    2: "logStatusWarning logStatusDiscard logStatusError",
    3: "logStatusWarning logStatusError logStatusFatal",
}


def log_of(folder: Path, version: int, categories: tuple[str, ...], place: str = "here") -> str:
    listed = "".join(f'<Category name="{name}"/>' for name in categories)
    fmu = foreign_fmu(
        folder,
        version,
        scalar(version, "u", 1, causality="input", start="0"),
        snippet=TELLS,
        before=f"<LogCategories>{listed}</LogCategories>" if categories else "",
    )
    keys = ", isolate: process" if "isolated" in place else ""
    file = folder / "test.yaml"
    file.write_text(
        "cohaptic: 1\nduration: 0.04\nbase_rate: 100\ncomponents:\n"
        f"  f: {{fmu: {fmu}, rate: 100{keys}}}\nrecord: [f.u]\n"
    )
    options = RunOptions(figure=False, realtime="paced" in place)
    finished = run_one(read_one(str(file), options, print), folder / "out", options, print)
    assert finished.error is None
    return (finished.folder / LOG_FILE).read_text()


def lines(categories: str) -> str:
    steps = f"f: warning: it is on (4 times)\nf: warning: {categories} (4 times)\n"
    return f"{steps}f: warning: that was all\nf: warning: free at last\n"


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("version", [2, 3])
def test_the_categories_of_what_goes_wrong_are_chosen(
    tmp_path: Path, version: int, place: str
) -> None:
    found = log_of(tmp_path, version, OF_THE_STANDARD[version], place)
    assert found == lines(CHOSEN[version])


@pytest.mark.parametrize("categories", [(), ("logEvents", "performance")])
@pytest.mark.parametrize("version", [2, 3])
def test_without_such_categories_everything_is_asked_for(
    tmp_path: Path, version: int, categories: tuple[str, ...]
) -> None:
    assert log_of(tmp_path, version, categories) == lines("no categories")
