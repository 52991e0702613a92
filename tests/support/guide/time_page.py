"""The rows of docs/time.md, from a run: ``python -m tests.support.guide.time_page``."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from cosim.reading import load
from cosim.record import open_run
from cosim.run import run_scenario

PAGE = Path(__file__).parents[3] / "docs" / "time.md"
ROWS = re.compile(r"(<!-- rows -->\n)(.*?)(<!-- end of rows -->)", re.DOTALL)
SIGNALS = (
    *("source.value", "sink.of_n0", "sink.of_n1"),
    *("n1.forward.age", "n1.forward.sequence", "sink.of_n2"),
)


def rows(folder: Path) -> list[tuple[int, ...]]:
    """Tick and ``SIGNALS`` of every tick of the page's scenario, run in ``folder``."""
    text = PAGE.read_text(encoding="utf-8")
    for language, name in (("python", "ticks.py"), ("yaml", "ticks.yaml")):
        (found,) = re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)
        (folder / name).write_text(found, encoding="utf-8")
    finished = run_scenario(load(folder / "ticks.yaml"), folder / "run", figure=False)
    with open_run(finished.folder) as run:
        columns = [run[name].values.tolist() for name in SIGNALS]
    return [
        (tick, *(int(value) for value in row))
        for tick, row in enumerate(zip(*columns, strict=True))
    ]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        lines = "".join(f"| {' | '.join(map(str, row))} |\n" for row in rows(Path(scratch)))
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(ROWS.sub(lambda mark: mark[1] + lines + mark[3], page), encoding="utf-8")
