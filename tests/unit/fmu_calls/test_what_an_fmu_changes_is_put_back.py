"""Working directory, locale, float mode and signals: an FMU cannot change them for others."""

from __future__ import annotations

import locale
import os
import signal
import sys
from pathlib import Path

import pytest

from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import scenario_of

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the snippets are Linux's")

CALLS = ["Instantiate", "EnterInitializationMode", "DoStep", "Terminate"]
SNIPPET = """
    int chdir(const char *); char *setlocale(int, const char *);
    void *signal(int, void *); int sigemptyset(void *); int sigaddset(void *, int);
    int sigprocmask(int, const void *, void *);
    static int hook(Foreign *m, const char *call)
    {{
        if (is(call, "{call}")) {{
            unsigned long set[16];
            chdir("/"), setlocale(6, "C.UTF-8");
            for (int number = 1; number < 18; number++)
                if (number == 2 || number == 15 || number == 17)
                    signal(number, (void *)1);
            sigemptyset(set), sigaddset(set, 10), sigprocmask(0, set, 0);
        }}
        return 0;
    }}
    #define HOOK hook
"""


@pytest.fixture
def plain_locale():
    before = locale.setlocale(locale.LC_ALL)
    locale.setlocale(locale.LC_ALL, "C")
    yield
    locale.setlocale(locale.LC_ALL, before)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("call", CALLS)
def test_after_any_call_the_process_is_as_it_was(
    tmp_path: Path, call: str, version: int, plain_locale: None
) -> None:
    path = foreign_fmu(
        tmp_path,
        version,
        scalar(version, "y", 1, causality="output"),
        structure='<Output valueReference="1" dependencies=""/>'
        if version == 3
        else '<Outputs><Unknown index="1" dependencies=""/></Outputs>',
        snippet=SNIPPET.format(call=call),
    )
    written = {"duration": 0.02, "components": {"it": {"fmu": str(path), "rate": 100}}}
    here, handler = Path.cwd(), signal.getsignal(signal.SIGINT)
    with assemble(scenario_of(tmp_path, written)) as simulation:
        outcome = simulation.run(MemorySink())
    assert Path.cwd() == here
    assert locale.setlocale(locale.LC_ALL) == "C"
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == set()
    assert signal.getsignal(signal.SIGINT) is handler
    with pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGINT)
    if call != "Terminate":  # everything is written by then
        said = [str(each) for each in outcome.said["it"]]
        for what in ("working directory", "locale", "handler of SIGTERM", "signals are blocked"):
            assert any(what in text and "was put back" in text for text in said), said


STATEFUL = (
    SNIPPET
    + """
    static int lives(Foreign *m, const char *call) {{ return hook(m, call); }}
    EXPORT int fmi3GetFMUState(Foreign *m, void **state) {{ *state = m; return lives(m, "Get"); }}
    EXPORT int fmi3SetFMUState(Foreign *m, void *state) {{ return lives(m, "Put"); }}
    EXPORT int fmi3FreeFMUState(Foreign *m, void **state) {{ *state = 0; return 0; }}
    EXPORT int fmi3SerializedFMUStateSize(Foreign *m, void *state, size_t *size)
    {{ *size = 8; return 0; }}
    EXPORT int fmi3SerializeFMUState(Foreign *m, void *state, char *bytes, size_t size)
    {{ return 0; }}
    EXPORT int fmi3DeserializeFMUState(Foreign *m, const char *bytes, size_t size, void **state)
    {{ *state = m; return 0; }}
"""
)


@pytest.mark.parametrize("call", ["DoStep", "Get", "Put"])
def test_so_it_is_where_runs_are_led_by_hand(tmp_path: Path, call: str, plain_locale: None) -> None:
    """Run on, saved and put back by the methods of a simulation."""
    path = foreign_fmu(
        tmp_path,
        3,
        scalar(3, "y", 1, causality="output"),
        structure='<Output valueReference="1" dependencies=""/>',
        snippet=STATEFUL.format(call=call),
        interface={"canGetAndSetFMUState": "true", "canSerializeFMUState": "true"},
    )
    written = {"duration": 0.1, "components": {"it": {"fmu": str(path), "rate": 100}}}
    here = Path.cwd()
    with assemble(scenario_of(tmp_path, written)) as simulation:
        simulation.start()
        if call == "Get":
            simulation.snapshot()
        elif call == "Put":
            simulation.restore(simulation.snapshot())
        else:
            simulation.advance(3)
        said = [str(each) for each in simulation.fmus["it"].said()]
        assert any("working directory" in each for each in said), said
        assert Path.cwd() == here
        assert locale.setlocale(locale.LC_ALL) == "C"
        assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == set()
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)


def test_an_fmu_that_changes_nothing_is_said_nothing_of(tmp_path: Path) -> None:
    path = foreign_fmu(tmp_path, 3, scalar(3, "u", 1, causality="input", start="0"))
    written = {"duration": 1, "components": {"it": {"fmu": str(path), "rate": 100}}}
    with assemble(scenario_of(tmp_path, written)) as simulation:
        assert simulation.run(MemorySink()).said == {}


DENORMALS = """
    static int hook(Foreign *m, const char *call)
    {
        unsigned mode = 0x1f80 | 0x8040 | 0x2000; /* flush to zero, and round down */
        if (is(call, "DoStep") || is(call, "GetFloat64"))
            __asm__ volatile("ldmxcsr %0" : : "m"(mode));
        return 0;
    }
    #define HOOK hook
"""


@pytest.mark.skipif(os.uname().machine != "x86_64", reason="the snippet is x86-64's")
def test_no_call_changes_how_the_next_one_computes(tmp_path: Path) -> None:
    """A conversion of units rounds as it always does, and denormals stay what they are."""
    variables = scalar(3, "y", 1, causality="output", unit="h", start="5e-322", initial="exact")
    rest = {
        "structure": '<Output valueReference="1" dependencies=""/>',
        "before": '<UnitDefinitions><Unit name="h"><BaseUnit s="1" factor="3600"/></Unit>'
        "</UnitDefinitions>",
    }
    found = []
    for number, snippet in enumerate(["", DENORMALS]):
        folder = tmp_path / str(number)
        folder.mkdir()
        source = foreign_fmu(folder, 3, variables, snippet=snippet, **rest)
        sink = MemorySink()
        written = {
            "duration": 0.05,
            "components": {
                "it": {"fmu": str(source), "rate": 100, "start": {"y": 5e-322}},
                "signal": {"fmu": str(source_of_minutes(folder)), "rate": 100},
            },
            "connections": ["it.y -> signal.u"],
        }
        with assemble(scenario_of(folder, written)) as simulation:
            simulation.run(sink)
        found.append(list(sink.signal("signal.u")))
    assert found[0][-1] > 0
    assert found[0] == found[1]


def source_of_minutes(folder: Path) -> Path:
    unit = (
        '<UnitDefinitions><Unit name="min"><BaseUnit s="1" factor="60"/></Unit></UnitDefinitions>'
    )
    variables = scalar(3, "u", 1, causality="input", unit="min", start="0")
    return foreign_fmu(
        folder, 3, variables, before=f"<UnitDefinitions>{unit}</UnitDefinitions>", name="minutes"
    )
