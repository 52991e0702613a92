"""``cohaptic theory loss``: how much packet loss a loop survives in mean square."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, get_args

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.run_options import RunLoop
from cosim.theory.chance.mean_square import critical_loss, mean_square_radius
from cosim.theory.chance.packets import LinkProcess, Losses, bernoulli, gilbert_elliott

if TYPE_CHECKING:
    from cosim.scenario.impairments.loss import GilbertElliott


@click.command(cls=JsonCommand)
@click.option(
    "--losses",
    type=click.Choice(get_args(Losses)),
    default="independent",
    show_default=True,
    help="Whether the directions lose packets independently or together.",
)
@click.option(
    "--loss", type=Number(0, 1), metavar="P", help="Also the mean-square radius at this loss."
)
@click.option(
    "--burst",
    type=Number(1, 1e6),
    metavar="PACKETS",
    help="Mean burst length at that loss (Gilbert–Elliott).",
)
@loop_options(chapter=5, runs=True)
def command(
    loop: Loop | RunLoop, as_json: bool, losses: Losses, loss: float | None, burst: float | None
) -> None:
    """Critical loss probability: the smallest at which the loop is not mean-square stable.

    null (JSON) or "none" (text) where no loss below 0.999 destabilises the loop. A lost packet
    leaves the value held before. With --scenario the map of every fate is that of the run, with the
    jitter of its channels and in place of their own loss, which theory radius answers for.
    """
    if isinstance(loop, RunLoop):
        _of_run(loop, losses, loss, burst, as_json=as_json)
        return
    critical = critical_loss(loop.model, loop.timing, losses)
    result: dict[str, object] = {
        "critical_loss": critical,
        "losses": losses,
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    lines = [describe(loop), _sentence(critical, losses)]
    if loss is not None:
        radius = mean_square_radius(loop.model, loop.timing, _process(loss, burst), losses)
        result |= {"mean_square_radius": radius, "mean_square_stable": radius < 1.0}
        verdict = "stable" if radius < 1.0 else "unstable"
        lines.append(f"at loss {loss:g}: mean-square radius {radius:.6g}, {verdict}")
    elif burst is not None:
        raise InputError("--burst needs the loss probability too: add --loss, such as 0.02.")
    emit(result, "\n".join(lines), as_json=as_json, notes=loop.notes)


def _of_run(
    loop: RunLoop, losses: Losses, loss: float | None, burst: float | None, *, as_json: bool
) -> None:
    from cosim.analysis.answers.chance import with_losses
    from cosim.cli.theory.support.run_answer import about, place

    with loop.asked() as asked:
        chance = with_losses(asked.point(), losses)
        critical = chance.critical_loss()
        result: dict[str, object] = {"critical_loss": critical, "losses": losses, **about(asked)}
        lines = [place(asked), _sentence(critical, losses)]
        if loss is not None:
            radius = chance.radius(_own(loss, burst))
            result |= {"mean_square_radius": radius, "mean_square_stable": radius < 1.0}
            verdict = "stable" if radius < 1.0 else "unstable"
            lines.append(f"at loss {loss:g}: mean-square radius {radius:.6g}, {verdict}")
        elif burst is not None:
            raise InputError("--burst needs the loss probability too: add --loss, such as 0.02.")
        emit(result, "\n".join(lines), as_json=as_json, notes=asked.notes)


def _process(loss: float, burst: float | None) -> Callable[[int], LinkProcess]:
    """From a link's delay to its losses."""
    if burst is None:
        return partial(bernoulli, loss)
    return partial(gilbert_elliott, *_chain(loss, burst))


def _own(loss: float, burst: float | None) -> float | GilbertElliott:
    """The same losses as a channel has them."""
    from cosim.scenario.impairments.loss import GilbertElliott

    if burst is None:
        return loss
    onset, recovery = _chain(loss, burst)
    return GilbertElliott(good_to_bad=onset, bad_to_good=recovery)


def _chain(loss: float, burst: float) -> tuple[float, float]:
    """From good to bad and back, a packet."""
    if burst < 1 or not 0 < loss < 1:
        raise InputError("A burst is at least 1 packet long, at a loss between 0 and 1.")
    recovery = 1.0 / burst
    onset = recovery * loss / (1.0 - loss)
    if onset > 1:
        raise InputError(
            f"A loss of {loss:g} cannot come in bursts of only {burst:g} packets: the mean burst "
            f"is then at least {loss / (1 - loss):.3g}."
        )
    return onset, recovery


def _sentence(critical: float | None, losses: Losses) -> str:
    if critical is None:
        return f"critical loss: none below 0.999 ({losses} losses)"
    if critical == 0.0:
        return "critical loss 0: the loop is unstable without any loss"
    return f"critical loss {critical:.6g} ({losses} losses)"
