"""The figures of what lies past the thesis."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cosim.plot.style import COLOURS, legend_above
from cosim.report.overview import STYLE
from cosim.thesis.pages.figures import DPI, SIZE
from cosim.thesis.sweeps.beyond import RADIUS_DELAYS, Beyond
from cosim.thesis.sweeps.breaking import Limit
from cosim.thesis.sweeps.free_motions import DELAYS, PREDICTORS
from cosim.thesis.sweeps.trials import Motion


def draw_beyond(found: Beyond, out: Path) -> dict[str, Path]:
    """Draw the figures into ``out``: name -> file."""
    importlib.import_module("matplotlib").use("agg")
    pyplot: Any = importlib.import_module("matplotlib.pyplot")
    drawn: dict[str, Path] = {}
    with pyplot.rc_context(STYLE):
        for name, draw in FIGURES.items():
            figure: Any = pyplot.figure(figsize=SIZE, dpi=DPI, layout="constrained")
            draw(figure, found)
            drawn[name] = out / f"figure_{name}.png"
            figure.savefig(drawn[name])
            pyplot.close(figure)
    return drawn


def _breaking(figure: Any, found: Beyond) -> None:
    stiffness, jitter, loss = figure.subplots(1, 3)
    _curve(stiffness, found.limits["stiffness"], COLOURS[0], "centralized")
    _curve(jitter, found.limits["jitter"], COLOURS[0], "centralized")
    jitter.set(
        title="(b) The same under jitter", xlabel="each packet late by 0 to … samples", yscale="log"
    )
    jitter.set_xticks([one.delay for one in found.limits["jitter"]])
    legend_above(jitter, 1)
    stiffness.set(
        title="(a) Stiffest remote couplers",
        ylabel="normal stiffness (N/m)",
        yscale="log",
    )
    _curve(loss, found.limits["centralized_loss"], COLOURS[0], "centralized, soft")
    _curve(loss, found.limits["distributed_loss"], COLOURS[1], "distributed")
    loss.set(title="(c) Largest loss that holds", ylabel="loss probability", ylim=(-0.03, 1.03))
    for axis in (stiffness, loss):
        axis.set_xlabel("round-trip delay (samples)")
        axis.set_xticks([one.delay for one in found.limits["stiffness"]])
        legend_above(axis, 1)


def _curve(axis: Any, limits: tuple[Limit, ...], colour: str, label: str) -> None:
    """The theory as a line, simulation as the interval in which it has the limit."""
    theory = [one for one in limits if one.predicted is not None]
    if theory:
        axis.plot(
            [one.delay for one in theory],
            [one.predicted for one in theory],
            "-",
            color=colour,
            label=f"{label}: theory",
        )
    middle = [one.found for one in limits]
    axis.errorbar(
        [one.delay for one in limits],
        middle,
        yerr=[
            [value - one.holds for value, one in zip(middle, limits, strict=True)],
            [one.breaks - value for value, one in zip(middle, limits, strict=True)],
        ],
        fmt="o",
        color=colour,
        capsize=3,
        label=f"{label}: simulation" + ("" if theory else " (theory: none)"),
    )


def _realism(figure: Any, found: Beyond) -> None:
    ripple, force = figure.subplots(1, 2, sharey=True)
    names = list(found.realism)
    places = list(range(len(names)))
    ideal = found.realism["all ideal"].net_force
    ripple.barh(places, [1e3 * one.ripple for one in found.realism.values()], color=COLOURS[0])
    ripple.set(title="Ripple of the net force", xlabel="mN rms")
    force.barh(
        places,
        [1e3 * (one.net_force - ideal) for one in found.realism.values()],
        color=COLOURS[1],
    )
    force.set(title="Amplitude, against all ideal", xlabel="mN")
    ripple.set_yticks(places, names)
    ripple.invert_yaxis()


def _prediction(figure: Any, found: Beyond) -> None:
    axes = figure.subplots(1, 3)
    panels: tuple[tuple[str, str, Callable[[Motion], float]], ...] = (
        ("Net force", "N", lambda one: one.net_force),
        ("Drift between the copies", "mm rms", lambda one: 1e3 * one.drift),
        ("Ripple of the net force", "mN rms", lambda one: 1e3 * one.ripple),
    )
    for axis, (title, unit, value) in zip(axes, panels, strict=True):
        for number, name in enumerate(PREDICTORS):
            values = [value(found.predictors[name, delay]) for delay in DELAYS]
            axis.plot(DELAYS, values, "o-", color=COLOURS[number], label=name.replace("_", " "))
        axis.set(title=title, ylabel=unit, ylim=(0, None), xlabel="round trip (samples)")
        axis.set_xticks(DELAYS)
    legend_above(axes[0], 2)


def _users(figure: Any, found: Beyond) -> None:
    axis = figure.subplots()
    for number, (users, radii) in enumerate(found.radii.items()):
        axis.plot(RADIUS_DELAYS, radii, "o-", color=COLOURS[number], label=f"{users} users")
    axis.set(
        title="Spectral radius of the grasp, distributed control",
        xlabel="round-trip delay (network samples)",
        ylabel="ρ over a network period",
    )
    axis.set_xticks(RADIUS_DELAYS)
    legend_above(axis)


FIGURES: dict[str, Callable[[Any, Beyond], None]] = {
    "breaking": _breaking,
    "realism": _realism,
    "prediction": _prediction,
    "users": _users,
}
"""Name -> the function that draws it."""
