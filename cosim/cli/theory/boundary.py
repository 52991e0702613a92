"""``cohaptic theory boundary``: where along a parameter a loop is stable."""

from __future__ import annotations

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.reading import read_range
from cosim.cli.theory.support.run_options import RunLoop
from cosim.theory.stability.spectral_radius import stability, stable_intervals


@click.command(cls=JsonCommand)
@click.option("--vary", required=True, metavar="NAME", help="The parameter that moves.")
@click.option("--range", "span", required=True, metavar="LOW:HIGH", help="Where it moves.")
@loop_options(chapter=5, runs=True)
def command(loop: Loop | RunLoop, as_json: bool, vary: str, span: str) -> None:
    """All stable intervals along one parameter; regions may be re-entrant."""
    low, high = read_range(span)
    if isinstance(loop, RunLoop):
        _of_run(loop, vary, low, high, as_json=as_json)
        return
    # Both ends must be allowed values; what lies between is then allowed too.
    for end in (low, high):
        loop.parameters.replaced({vary: end})

    def radius(value: float) -> float:
        model = loop.parameters.replaced({vary: value}).model()
        return stability(model, loop.timing).spectral_radius

    intervals = stable_intervals(radius, low, high)
    result = {
        "stable": [list(interval) for interval in intervals],
        "vary": vary,
        "range": [low, high],
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    text = f"{describe(loop)}\n{_sentence(vary, low, high, intervals)}"
    emit(result, text, as_json=as_json, notes=loop.notes)


def _sentence(vary: str, low: float, high: float, intervals: list[tuple[float, float]]) -> str:
    listed = "\n".join(f"  {start:.6g} to {stop:.6g}" for start, stop in intervals)
    if intervals:
        return f"{vary} is stable from\n{listed}"
    return f"no stable {vary} between {low:g} and {high:g}"


def _of_run(loop: RunLoop, vary: str, low: float, high: float, *, as_json: bool) -> None:
    from cosim.analysis.answers.vary import intervals_of_run
    from cosim.cli.theory.support.run_answer import about, place

    with loop.asked() as asked:
        intervals = intervals_of_run(asked, vary, low, high)
        result = {
            "stable": [list(interval) for interval in intervals],
            "vary": vary,
            "range": [low, high],
            **about(asked),
        }
        text = f"{place(asked)}\n{_sentence(vary, low, high, intervals)}"
        emit(result, text, as_json=as_json, notes=asked.notes)
