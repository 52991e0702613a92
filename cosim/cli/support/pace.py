"""How a run keeps pace: the command line wins over the scenario's ``realtime:``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import click

from cosim.base.errors import InputError
from cosim.cli.support.effect import refuse_without

if TYPE_CHECKING:
    from cosim.scenario import Scenario

Policy = Literal["count", "stop"]
Command = Callable[..., Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pace:
    """What holds for this run; ``cpu`` is ``None`` where any processor will do."""

    on_miss: Policy = "count"
    cpu: int | None = None


def pace_of(scenario: Scenario, *, on_miss: Policy | None, cpu: int | None) -> Pace:
    """What the command line says, and where it says nothing the scenario."""
    written = scenario.realtime
    return Pace(
        on_miss=on_miss or written.get("on_miss") or "count",
        cpu=written.get("cpu") if cpu is None else cpu,
    )


def refuse_without_realtime(*, realtime: bool, on_miss: Policy | None, cpu: int | None) -> None:
    """Refuse options that act on the clock's pace alone.

    Raises:
        InputError: one was given to a run that keeps no pace.
    """
    if not realtime:
        refuse_without(
            "--realtime",
            {"--on-miss": on_miss, "--cpu": cpu},
            "nothing keeps pace with the clock",
        )


def _refuse_policy(context: click.Context, parameter: click.Parameter, value: str | None) -> None:
    del context, parameter
    if value is not None:
        raise InputError(f"--policy is called --on-miss: write --on-miss {value}.")


def miss_options(command: Command) -> Command:
    """``--on-miss``, and its name of earlier releases, which says what to write instead."""
    command = click.option(
        "--policy", hidden=True, expose_value=False, callback=_refuse_policy, is_eager=True
    )(command)
    return click.option(
        "--on-miss",
        type=click.Choice(["count", "stop"]),
        help="What a missed deadline means. [default: the scenario's, or count]",
    )(command)
