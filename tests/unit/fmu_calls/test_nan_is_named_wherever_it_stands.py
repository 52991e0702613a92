"""What an FMU puts out that is no number ends the run, whichever of its values it is, and whenever.

The kernel looks at the first and the last of several values at once, and in early ticks, when it
looks after foreign FMUs, in another loop than later.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import RunError
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

BREAKS = """
static int break_a_value(Foreign *m, const char *call)
{
    if (is(call, "DoStep"))
        m->real[%d] = m->time >= %d ? __builtin_nan("") : m->time;
    return 0;
}
#define HOOK break_a_value
"""


def putting_out(folder: Path, version: int, count: int, snippet: str = "") -> Path:
    """An FMU with ``count`` real outputs; its value references are their places."""
    folder.mkdir()
    variables = [scalar(version, f"y{n}", n, causality="output") for n in range(count)]
    outputs = "".join(f'<Output valueReference="{n}"/>' for n in range(count))
    if version == 2:
        unknowns = "".join(f'<Unknown index="{n + 1}"/>' for n in range(count))
        outputs = f"<Outputs>{unknowns}</Outputs>"
    return foreign_fmu(folder, version, "\n".join(variables), structure=outputs, snippet=snippet)


@pytest.mark.parametrize("tick", [3, 100])
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("count", "place"), [(1, 0), (2, 0), (2, 1), (3, 1), (5, 0), (5, 3), (5, 4)]
)
def test_the_sentence_has_value_and_tick(
    tmp_path: Path, count: int, place: int, version: int, tick: int
) -> None:
    broken = putting_out(tmp_path / "broken", version, count, BREAKS % (place, tick - 1))
    whole = putting_out(tmp_path / "whole", version, count)
    components = {
        name: {"fmu": str(fmu), "rate": 1}
        for name, fmu in (("a", whole), ("b", broken), ("c", whole))
    }
    written = {"duration": 110, "base_rate": 1, "components": components}
    with pytest.raises(RunError, match=rf"^b\.y{place} became NaN at tick {tick} "):
        run(scenario_of(tmp_path, written))
