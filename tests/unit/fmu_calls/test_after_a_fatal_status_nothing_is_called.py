"""What may be called after which status: nothing after fatal, only freeing after an error."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import CohapticError
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import scenario_of

FAILS = """
    static Foreign *instances_begin(void);
    char *getenv(const char *);
    #include <stddef.h>
    int open(const char *, int, ...); long write(int, const void *, size_t); int close(int);
    static void note(Foreign *m, const char *call)
    {
        int file = open(getenv("NOTED_IN"), 1 | 64 | 1024, 0600); /* write, create, append */
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
        m->event = true; /* after every step */
        note(m, failed ? call : "-");
        if (is(call, getenv("FAILS_IN")) && m == instances_begin()) {
            failed = 1;
            return getenv("FAILS_WITH")[0] - '0';
        }
        return 0;
    }
    #define HOOK hook
"""


def calls_after(folder: Path, version: int, call: str, status: int, keys: str = "") -> list[str]:
    """What was called after ``call`` of the first of two instances had returned ``status``."""
    log = folder / "calls"
    kind = {2: "Real", 3: "Float64"}[version]
    event_mode = call.endswith(("States", "EventMode", "StepMode"))
    output = {
        2: '<Outputs><Unknown index="2" dependencies=""/></Outputs>',
        3: '<Output valueReference="2" dependencies=""/>',
    }[version]
    fmu = foreign_fmu(
        folder,
        version,
        scalar(version, "u", 1, causality="input", start="0")
        + scalar(version, "y", 2, causality="output"),
        snippet=FAILS,
        structure=output,
        interface={"hasEventMode": "true"} if event_mode else {},
    )
    more = f"rate: 1, start: {{u: 1}}{keys}" + ", event_mode: true" * event_mode
    written = (
        f"duration: 4\nbase_rate: 1\ncomponents:\n  a: {{fmu: {fmu}, {more}}}\n"
        f"  b: {{fmu: {fmu}, {more}}}\n"
    )
    called = {"Set": f"Set{kind}", "Get": f"Get{kind}"}.get(call, call)
    with pytest.MonkeyPatch.context() as given:
        for name, value in (("NOTED_IN", log), ("FAILS_IN", called), ("FAILS_WITH", status)):
            given.setenv(name, str(value))
        with pytest.raises(CohapticError), assemble(scenario_of(folder, written)) as simulation:
            simulation.run()
    return [line for line in log.read_text().splitlines() if not line.endswith("-")]


CALLS = [
    "SetupExperiment",
    "Set",
    "Get",
    "EnterInitializationMode",
    "ExitInitializationMode",
    "DoStep",
    "UpdateDiscreteStates",
    "EnterEventMode",
    "EnterStepMode",
    "Terminate",
]
CASES = [
    (version, call)
    for version in (2, 3)
    for call in CALLS
    if version == 3 or not call.endswith(("States", "EventMode", "StepMode"))
    if version == 2 or call != "SetupExperiment"
]
BEFORE_THE_OTHER = {"Set"}
"""Values are set as soon as an instance is there, before the next one is made."""


@pytest.mark.parametrize("keys", ["", ", isolate: process"])
@pytest.mark.parametrize(("version", "call"), CASES)
def test_fatal_is_the_end_of_the_instance_and_frees_the_others(
    tmp_path: Path, version: int, call: str, keys: str
) -> None:
    others = [] if call in BEFORE_THE_OTHER else ["other FreeInstance"]
    if keys:  # a library of its own, where each is the first instance
        others = []
    assert calls_after(tmp_path, version, call, 4, keys) == others


@pytest.mark.parametrize(("version", "call"), CASES)
def test_an_error_leaves_freeing_and_concerns_nobody_else(
    tmp_path: Path, version: int, call: str
) -> None:
    after = calls_after(tmp_path, version, call, 3)
    after = [each for each in after if each != "other Terminate"]
    others = [] if call in BEFORE_THE_OTHER else ["other FreeInstance"]
    assert after == ["first FreeInstance", *others]
