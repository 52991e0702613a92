"""What may be called after which status: nothing after fatal, only freeing after an error."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import CohapticError
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import scenario_of

FAILS = """
    #include <stddef.h>
    int open(const char *, int, ...); long write(int, const void *, size_t); int close(int);
    static void note(Foreign *m, const char *call)
    {
        int file = open("%(file)s", 1 | 64 | 1024, 0600); /* write, create, append */
        size_t length = 0;
        while (call[length])
            length++;
        write(file, m == instances_begin() ? "first " : "other ", 6);
        write(file, call, length);
        write(file, "\\n", 1);
        close(file);
    }
    static int failed;
    static int hook(Foreign *m, const char *call)
    {
        note(m, failed ? call : "-");
        if (is(call, "%(call)s") && m == instances_begin()) {
            failed = 1;
            return %(status)d;
        }
        return 0;
    }
    #define HOOK hook
"""


def calls_after(folder: Path, version: int, call: str, status: int) -> list[str]:
    """What was called after ``call`` of the first of two instances had returned ``status``."""
    log = folder / "calls"
    snippet = "static Foreign *instances_begin(void);" + FAILS % {
        "file": log,
        "call": call,
        "status": status,
    }
    fmu = foreign_fmu(
        folder, version, scalar(version, "u", 1, causality="input", start="0"), snippet=snippet
    )
    written = (
        f"duration: 4\nbase_rate: 1\ncomponents:\n  a: {{fmu: {fmu}, rate: 1}}\n"
        f"  b: {{fmu: {fmu}, rate: 1}}\n"
    )
    with pytest.raises(CohapticError), assemble(scenario_of(folder, written)) as simulation:
        simulation.run()
    return [line for line in log.read_text().splitlines() if not line.endswith("-")]


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("call", ["EnterInitializationMode", "ExitInitializationMode", "DoStep"])
def test_fatal_is_the_end_of_the_instance_and_frees_the_others(
    tmp_path: Path, version: int, call: str
) -> None:
    assert calls_after(tmp_path, version, call, 4) == ["other FreeInstance"]


@pytest.mark.parametrize("version", [2, 3])
def test_an_error_leaves_freeing_and_concerns_nobody_else(tmp_path: Path, version: int) -> None:
    assert calls_after(tmp_path, version, "DoStep", 3) == [
        "first FreeInstance",
        "other Terminate",
        "other FreeInstance",
    ]
