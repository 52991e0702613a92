"""``cohaptic theory design``: gains that follow from a measured network."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from cosim.base.errors import InputError
from cosim.base.system.writing import writing
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number, OutputFile
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.theory.chance.network import Network
from cosim.theory.design.overlay import overlay
from cosim.theory.design.search import design


@click.command(cls=JsonCommand)
@click.option(
    "--delay", type=Number(0, 1e3), metavar="S", help="Mean one-way delay, instead of samples."
)
@click.option("--jitter", type=Number(0, 1e3), metavar="S", help="RMS jitter, one way.")
@click.option(
    "--loss", type=Number(0, 1, max_open=True), metavar="P", help="Probability of loss, one way."
)
@click.option(
    "--margin",
    type=Number(0, 100),
    default=0.25,
    show_default=True,
    help="Stable with stiffness, damping or masses more or less by this fraction.",
)
@click.option("--explain", is_flag=True, help="Say what limits each stiffness; takes longer.")
@click.option("--confirm", is_flag=True, help="Ask the simulation in every corner as well.")
@click.option("--out", type=OutputFile(), help="Write the overlay here.")
@loop_options(chapter=5)
def command(
    *,
    loop: Loop,
    as_json: bool,
    delay: float | None,
    jitter: float | None,
    loss: float | None,
    margin: float,
    explain: bool,
    confirm: bool,
    out: Path | None,
) -> None:
    """The stiffest couplers, their damping and the compensation, stable in every corner.

    The corners: stiffness, damping and masses times 1 ± margin, a sample of delay more and less,
    fewer hands and none, the network's loss and jitter; all with the compensation in. The worst is
    named.

    With --scenario, delay, jitter and loss are those of its channels, the worse direction's where
    they differ. A gain given with --set is kept. The result is an overlay for the single-axis
    scenarios: cohaptic run scenarios/single_axis_distributed.yaml --with FILE.
    """
    if loop.architecture == "single":
        raise InputError(
            "A single user has no network to design for: use --architecture centralized or "
            "distributed, or theory boundary for the single loop's own limit."
        )
    timing = loop.timing
    samples = max(timing.delay.forward, timing.delay.backward)
    known = Network(
        period=timing.network_period,
        delay=samples * float(timing.network_period),
        jitter=0.0,
        loss=0.0,
    )
    if loop.scenario is not None:
        from cosim.analysis.network import network_of

        measured = network_of(loop.scenario) or known
        known = replace(measured, delay=known.delay) if loop.says_delay else measured
    network = Network(
        period=timing.network_period,
        delay=known.delay if delay is None else delay,
        jitter=known.jitter if jitter is None else jitter,
        loss=known.loss if loss is None else loss,
    )
    found = design(
        loop.parameters,
        network,
        timing.control_period,
        margin,
        explain=explain,
        computation_delay=timing.computation_delay,
    )
    written = overlay(loop.parameters, found)
    if out is not None:
        with writing(out):
            out.write_text(written, encoding="utf-8")
    said: list[str] = []
    result: dict[str, object] = {}
    if confirm:
        from cosim.analysis.answers.confirmed import confirmed

        seen = confirmed(loop.parameters, network, found, margin)
        worst = max(seen, key=lambda name: seen[name])
        said.append(f"in the simulation: {worst}, radius {seen[worst]:.6g}")
        result["simulated_corners"] = seen
    result |= {
        "gains": found.gains,
        "compensation": found.compensation,
        "corners": found.corners,
        "worst_corner": found.worst,
        "limited_by": found.limited_by,
        "limits": found.limits,
        "margin": margin,
        "delay_samples": found.timing.delay.forward,
        "overlay": written,
        "architecture": loop.architecture,
    }
    reasons = [
        f"{name} is limited by: {cause}"
        + ("" if cause == "itself" else f" (without it {found.limits[name][cause]:.2g} times)")
        for name, cause in found.limited_by.items()
    ]
    where = f"written to {out}" if out is not None else written
    text = "\n".join(
        [
            describe(Loop(loop.parameters, found.timing)),
            (
                f"stable in all {len(found.corners)} corners with compensation "
                f"{found.compensation:.4g} N·s/m"
            ),
            f"nearest to instability: {found.worst}, radius {found.corners[found.worst]:.6g}",
            *said,
            *reasons,
            where,
        ]
    )
    from cosim.analysis.single_axis_parts import WITHOUT_CHANCE

    notes = tuple(note for note in loop.notes if note != WITHOUT_CHANCE)
    emit(result, text, as_json=as_json, notes=notes)
