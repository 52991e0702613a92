"""The options that every theory command shares."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, cast

import click

from cosim.base.errors import InputError
from cosim.cli.theory.support.loop import Loop
from cosim.cli.theory.support.reading import read_delay, read_fraction, read_setting
from cosim.cli.theory.support.run_options import (
    RUN_OPTIONS,
    is_path,
    read_run,
    refuse_run_options,
)
from cosim.theory.models.parameters import (
    ARCHITECTURES,
    CHAPTER_5,
    TABLE_6_1,
    Architecture,
    Parameters,
)
from cosim.theory.models.timing import PathDelay, Timing

if TYPE_CHECKING:
    from cosim.analysis.single_axis import ScenarioLoop
    from cosim.scenario import Scenario

DEFAULTS: dict[int, dict[Architecture, dict[str, float]]] = {5: CHAPTER_5, 6: TABLE_6_1}


def loop_options(
    chapter: int,
    implied: Callable[[Mapping[str, Any]], Architecture | None] | None = None,
    *,
    runs: bool = False,
    exact: bool = False,
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add the shared options to a command, which then takes ``loop`` and ``as_json``.

    Args:
        chapter: whose constants are the defaults, 5 or 6.
        implied: the architecture that the command's own options imply, which may then be left
            unsaid, but not contradicted.
        runs: a scenario is taken as it runs: ``loop`` is then a ``RunLoop``.
        exact: a scenario whose run is another loop than the one it is read as is refused.
    """

    def decorate(function: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(function)
        def wrapper(**values: Any) -> None:
            shared = {name: values.pop(name) for name in _SHARED}
            moment = {name: values.pop(name) for name in ("at", "ideal", "window") if runs}
            if runs and shared["scenario"] is not None:
                asked = read_run(
                    shared["scenario"],
                    shared["overlays"],
                    shared["settings"],
                    {**shared, **moment},
                )
                function(loop=asked, **values)
                return
            refuse_run_options({"at": None, "ideal": None, "window": None, **moment})
            meant = implied(values) if implied is not None else None
            if meant is not None:
                if shared["architecture"] not in {None, meant}:
                    raise InputError(
                        f"--architecture {shared['architecture']} has no such user: it belongs to "
                        f"--architecture {meant}."
                    )
                shared["architecture"] = meant
            function(loop=_loop(chapter, exact=exact, **shared), **values)

        decorated: Callable[..., None] = wrapper
        for option in reversed((*_OPTIONS[:-1], *(RUN_OPTIONS if runs else ()), _OPTIONS[-1])):
            decorated = option(decorated)
        return decorated

    return decorate


_SHARED = (
    "architecture",
    "scenario",
    "overlays",
    "settings",
    "round_trip_delay",
    "each_way_delay",
    "forward_delay",
    "backward_delay",
    "ratio",
    "sampling",
    "control_rate",
    "computation_delay",
    "users",
)
_OPTIONS = (
    click.option("--architecture", type=click.Choice(ARCHITECTURES), help="Which loop."),
    click.option("--scenario", metavar="FILE", help="Read the loop from a scenario."),
    click.option("--with", "overlays", multiple=True, metavar="FILE", help="Overlay for it."),
    click.option(
        "--set",
        "settings",
        multiple=True,
        metavar="NAME=VALUE",
        help="A parameter, or with --scenario a dotted path in it; repeatable.",
    ),
    click.option(
        "--round-trip-delay",
        type=int,
        metavar="N",
        help="Network samples: ⌈n/2⌉ there, ⌊n/2⌋ back.",
    ),
    click.option("--each-way-delay", type=int, metavar="N", help="Network samples, both ways."),
    click.option("--forward-delay", type=int, metavar="I", help="Network samples forward."),
    click.option("--backward-delay", type=int, metavar="J", help="Network samples backward."),
    click.option("--ratio", metavar="N", help="T_t / T_c, such as 8 or 17/2.  [default: 8]"),
    click.option(
        "--sampling",
        type=click.Choice(["last-tick", "between-ticks"]),
        help="Where the ratio is not whole, what is sent between two control ticks: what was known "
        "at the last, as the master and devices do, or what is so right then.  "
        "[default: last-tick]",
    ),
    click.option("--control-rate", metavar="HZ", help="1 / T_c.  [default: 1024]"),
    click.option(
        "--computation-delay",
        type=int,
        metavar="TICKS",
        help="Control ticks from a coupler's inputs to its force.  [default: 0]",
    ),
    click.option("--users", type=int, metavar="M", help="Number of users.  [default: 2]"),
    click.option("--json", "as_json", is_flag=True, help="Print one JSON object."),
)


def _loop(
    chapter: int,
    *,
    exact: bool,
    architecture: str | None,
    scenario: str | None,
    overlays: tuple[str, ...],
    settings: tuple[str, ...],
    round_trip_delay: int | None,
    each_way_delay: int | None,
    forward_delay: int | None,
    backward_delay: int | None,
    ratio: str | None,
    sampling: str | None,
    control_rate: str | None,
    computation_delay: int | None,
    users: int | None,
) -> Loop:
    delay_forms = (round_trip_delay, each_way_delay, forward_delay, backward_delay)
    given_delay = loaded = None
    if any(form is not None for form in delay_forms):
        given_delay = read_delay(*delay_forms)
    if scenario is not None:
        paths = tuple(text for text in settings if is_path(text))
        found, loaded = _from_scenario(scenario, overlays, paths, exact=exact)
        if architecture not in {None, found.architecture} or users not in {None, found.users}:
            raise InputError(
                f"{scenario} is {found.architecture} with {found.users} users, which contradicts "
                "what --architecture or --users say: leave them out."
            )
        named, count, defaults = found.architecture, found.users, found.values
        settings = tuple(text for text in settings if text not in paths)
        base, notes = found.timing, found.notes
    else:
        if architecture is None:
            raise InputError(
                f"Say which loop: --architecture {'|'.join(ARCHITECTURES)}, or --scenario FILE."
            )
        if overlays:
            raise InputError("--with lays a file over a scenario: give --scenario FILE too.")
        named = cast("Architecture", architecture)
        count = 2 if users is None else users
        defaults, base, notes = DEFAULTS[chapter][named], Timing(), ()
    given = dict(read_setting(text) for text in settings)
    parameters = Parameters(named, given, defaults, count)
    changes: dict[str, Any] = {}
    if control_rate is not None:
        changes["control_period"] = 1 / read_fraction("--control-rate", control_rate)
    if ratio is not None:
        changes["ratio"] = read_fraction("--ratio", ratio)
    if sampling is not None:
        changes["sampling"] = sampling.replace("-", "_")
    if given_delay is not None:
        changes["delay"] = given_delay
    if computation_delay is not None:
        changes["computation_delay"] = computation_delay
    if named == "single":
        if ratio is not None or given_delay is not None:
            raise InputError(
                "A single user has no network, so that there is no ratio of rates and no delay: "
                "leave --ratio and the delay out, or take --computation-delay."
            )
        # One frame is one control tick.
        changes |= {"ratio": Fraction(1), "delay": PathDelay()}
    return Loop(parameters, replace(base, **changes), notes, loaded, given_delay is not None)


def _from_scenario(
    name: str, overlays: tuple[str, ...], paths: tuple[str, ...], *, exact: bool
) -> tuple[ScenarioLoop, Scenario]:
    from cosim.analysis.compensation import tuned
    from cosim.analysis.loop import read_loop
    from cosim.analysis.monodromy.refusal import refuse_turned
    from cosim.scenario.load import read

    written = tuned(read(name, overlays, paths))
    scenario = written.built()
    refuse_turned(scenario)
    found = read_loop(scenario)
    if exact:
        from cosim.analysis.exact_loop import refuse_another_loop

        refuse_another_loop(written, found)
    return found, scenario
