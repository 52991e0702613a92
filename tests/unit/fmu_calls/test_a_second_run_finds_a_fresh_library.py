"""What a library keeps in static memory does not reach the next run of the same process."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import scenario_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the snippets are POSIX's")

COUNTING = """
    static int steps;
    {more}
    static int hook(Foreign *m, const char *call)
    {{
        if (is(call, "DoStep"))
            m->real[1] = ++steps;
        {do}
        return 0;
    }}
    #define HOOK hook
"""
STAYS = {
    "more": "struct info { const char *file; void *base; const char *name; void *at; };"
    "int dladdr(const void *, struct info *); void *dlopen(const char *, int);",
    "do": 'struct info found; if (is(call, "Instantiate") && dladdr(&steps, &found))'
    " dlopen(found.file, 2 | 0x1000);",
}
LOST = {"more": "", "do": 'if (is(call, "DoStep") && steps == 5) return 4;'}


@pytest.mark.parametrize("how", ["it can be unloaded", "it stays loaded", "it was never freed"])
def test_every_run_begins_with_static_memory_as_it_was_compiled(tmp_path: Path, how: str) -> None:
    more = {"it stays loaded": STAYS, "it was never freed": LOST}.get(how, {"more": "", "do": ""})
    path = foreign_fmu(
        tmp_path,
        3,
        scalar(3, "y", 1, causality="output"),
        snippet=COUNTING.format(**more),
        structure='<Output valueReference="1" dependencies=""/>',
    )
    written = {"duration": 0.05, "components": {"it": {"fmu": str(path), "rate": 100}}}
    for _ in range(3):
        sink = MemorySink()
        with assemble(scenario_of(tmp_path, written)) as simulation:
            if how == "it was never freed":
                with pytest.raises(Exception, match="fatal"):
                    simulation.run(sink)
            else:
                simulation.run(sink)
        assert list(sink.signal("it.y")) == [0, 1, 2, 3, 4]


def test_what_was_never_freed_is_not_met_again(tmp_path: Path) -> None:
    """After a run with a private copy, too: the library itself is loaded still."""
    snippet = "char *getenv(const char *);" + COUNTING.format(
        more="", do='if (is(call, "DoStep") && steps == 5 && getenv("IS_LOST")) return 4;'
    )
    output = '<Output valueReference="1" dependencies=""/>'
    y = scalar(3, "y", 1, causality="output")
    path = foreign_fmu(tmp_path, 3, y, snippet=snippet, structure=output)
    written = {"duration": 0.05, "components": {"it": {"fmu": str(path), "rate": 100}}}
    for is_lost in (True, False, False, True, False, False):
        sink = MemorySink()
        with (
            pytest.MonkeyPatch.context() as given,
            assemble(scenario_of(tmp_path, written)) as simulation,
        ):
            if is_lost:
                given.setenv("IS_LOST", "1")
                with pytest.raises(Exception, match="fatal"):
                    simulation.run(sink)
            else:
                simulation.run(sink)
        assert list(sink.signal("it.y")) == [0, 1, 2, 3, 4]


def test_two_instances_of_a_run_share_it(tmp_path: Path) -> None:
    path = foreign_fmu(
        tmp_path,
        3,
        scalar(3, "y", 1, causality="output"),
        snippet=COUNTING.format(more="", do=""),
        structure='<Output valueReference="1" dependencies=""/>',
    )
    part = {"fmu": str(path), "rate": 100}
    sink = MemorySink()
    written = {"duration": 0.03, "components": {"a": part, "b": part}}
    with assemble(scenario_of(tmp_path, written)) as simulation:
        simulation.run(sink)
    assert list(sink.signal("b.y")) == [0, 2, 4]


def test_a_reset_of_a_stranger_is_never_asked_for(tmp_path: Path) -> None:
    """What it leaves behind nobody knows: a renewed run begins with a new instance."""
    path = foreign_fmu(
        tmp_path,
        3,
        scalar(3, "y", 1, causality="output"),
        snippet=COUNTING.format(more="", do='if (is(call, "Reset")) return 4;'),
        structure='<Output valueReference="1" dependencies=""/>',
    )
    written = {"duration": 0.03, "components": {"it": {"fmu": str(path), "rate": 100}}}
    with assemble(scenario_of(tmp_path, written)) as simulation:
        for _ in range(3):
            sink = MemorySink()
            simulation.run(sink, keep_fmus=True)
            assert list(sink.signal("it.y")) == [0, 1, 2]
            simulation.renew(simulation.assembly)
