"""``cohaptic theory modes``: how a run moves, and who takes part."""

from __future__ import annotations

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.theory.support.loop import Loop, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.run_options import RunLoop


@click.command(cls=JsonCommand)
@click.option(
    "--count", type=click.IntRange(1, 200), default=8, show_default=True, help="How many."
)
@loop_options(chapter=5, runs=True)
def command(loop: Loop | RunLoop, as_json: bool, count: int) -> None:
    """The modes of a run, slowest first: growth, frequency, and by whom it is carried.

    A grasp's are called squeeze, carry, lift and turn by how its fingers move.
    """
    if not isinstance(loop, RunLoop):
        raise InputError("Modes are those of a run: give --scenario FILE.")
    from cosim.analysis.answers.grasp_modes import named
    from cosim.analysis.monodromy.refusal import refuse_chance
    from cosim.cli.theory.support.run_answer import about, place

    with loop.asked() as asked:
        refuse_chance(asked.scenario, "modes are")
        point = asked.point()
        found = point.spectrum(with_modes=True)
        modes = found.modes[:count]
        names = named(point.run, modes)
        result = {
            "modes": [
                {
                    "name": name,
                    "magnitude": abs(mode.value),
                    "growth": mode.growth,
                    "frequency": mode.frequency,
                    "participation": {k: v for k, v in mode.participation.items() if v > 0.01},
                }
                for name, mode in zip(names, modes, strict=True)
            ],
            "period": float(found.period),
            "neutral_motions": found.neutral,
            **about(asked),
        }
        lines = [place(asked)]
        for name, mode in zip(names, modes, strict=True):
            shares = ", ".join(
                f"{owner} {share:.0%}" for owner, share in list(mode.participation.items())[:4]
            )
            lines.append(
                f"  {abs(mode.value):.6f}  {mode.growth:+9.3f} 1/s  {mode.frequency:8.2f} rad/s  "
                f"{name}: {shares}"
            )
        emit(result, "\n".join(lines), as_json=as_json, notes=asked.notes)
