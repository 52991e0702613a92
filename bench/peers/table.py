"""What was measured: as a table, and as a figure of ratios over the number of FMUs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

BARE = "bare C"


@dataclass(frozen=True)
class Row:
    """One master over one system: the least of its rounds (us a tick), or why there is none."""

    system: str
    size: int
    who: str
    microseconds: float
    ratio: float
    remark: str = ""
    """What it computed otherwise, or why it could not be asked."""
    is_wrong: bool = False
    """Whether that is so although it is known to compute the same."""


def printed(rows: Iterable[Row]) -> None:
    for row in rows:
        if row.microseconds == 0.0:
            print(f"  {row.who:<22} {'':>10}      {'':>8}   {row.remark}")
        else:
            figures = f"{row.microseconds:10.3f} us a tick {row.ratio:9.2f} x bare C"
            print(f"  {row.who:<22} {figures}   {row.remark}".rstrip())


def drawn(rows: list[Row], file: Path) -> None:
    """Ratios to bare C over the size, a panel for each kind of system."""
    import matplotlib as mpl

    mpl.use("agg")
    import matplotlib.pyplot as plt

    kinds = list(dict.fromkeys(row.system for row in rows if row.microseconds))
    names = list(dict.fromkeys(row.who for row in rows if row.microseconds))
    columns = min(2, len(kinds))
    lines = -(-len(kinds) // columns)
    figure, axes = plt.subplots(
        lines, columns, figsize=(4.0 * columns, 2.6 * lines), sharey=True, squeeze=False
    )
    for panel, kind in zip(axes.flat, kinds, strict=False):
        for number, who in enumerate(names):
            of_it = [row for row in rows if (row.system, row.who) == (kind, who)]
            timed = [(row.size, row.ratio) for row in of_it if row.microseconds]
            if timed:
                differs = any(row.remark for row in of_it)
                style = {"marker": "os^Dv<>P"[number % 8], "linestyle": ":" if differs else "-"}
                panel.plot(*zip(*timed, strict=True), label=who, color=f"C{number}", **style)
        panel.set(title=kind, xscale="log", yscale="log", xlabel="FMUs", ylabel="ratio to bare C")
        panel.set_xticks(sorted({row.size for row in rows if row.system == kind}))
        panel.xaxis.set_major_formatter("{x:.0f}")
        panel.minorticks_off()
    for panel in axes.flat[len(kinds) :]:
        panel.set_visible(False)
    handles = {
        text: handle
        for panel in axes.flat
        for handle, text in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4)
    figure.set_layout_engine("constrained")
    figure.savefig(file)
