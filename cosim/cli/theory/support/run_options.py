"""The options of commands that answer for a scenario as it runs, and what is asked of it."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import click

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.cli.theory.support.reading import read_setting

if TYPE_CHECKING:
    from cosim.analysis.answers.asked import AskedRun
    from cosim.scenario.load import Written

TOP_LEVEL = frozenset(
    {
        "base_rate",
        "channels",
        "cohaptic",
        "components",
        "connections",
        "description",
        "duration",
        "events",
        "expect",
        "knobs",
        "link",
        "name",
        "rates",
        "realtime",
        "record",
        "safety",
        "seed",
        "start_time",
        "title",
    }
)
"""Keys of a scenario, which --set may name without a dot; no parameter of the thesis has them."""

RUN_OPTIONS = (
    click.option(
        "--at", metavar="TIME", help="Moment of the run, such as '2 s'.  [default: its last rest]"
    ),
    click.option(
        "--ideal/--as-is",
        default=None,
        help="Without encoder counts, DAC, dry friction and FOAW, or with them.  [default: ideal]",
    ),
    click.option(
        "--window",
        type=click.IntRange(1, 31),
        help="Ticks of the difference that stands for FOAW.  [default: 4]",
    ),
)


@dataclass(frozen=True, slots=True)
class RunLoop:
    """A scenario as it runs: what the theory is asked about.

    Attributes:
        file: as it was given, for people.
        written: with overlays, overrides and delays.
        settings: parameters by the thesis's names.
        at: the moment (s).
        ideal: whether to take out what has no derivative.
        window: ticks of the difference that stands for FOAW.
    """

    file: str
    written: Written
    settings: tuple[tuple[str, float], ...]
    at: Fraction | None
    ideal: bool
    window: int

    def asked(self) -> AskedRun:
        """What is asked; a context manager that closes everything at the end."""
        from cosim.analysis.answers.asked import ask

        return ask(
            self.written,
            at=self.at,
            settings=self.settings,
            ideal=self.ideal,
            window=self.window,
        )


def read_run(
    file: str,
    overlays: tuple[str, ...],
    settings: tuple[str, ...],
    options: dict[str, Any],
) -> RunLoop:
    """The run that the options describe.

    Raises:
        InputError: they contradict the scenario, or it cannot be read.
    """
    from cosim.scenario.load import read

    for name in ("architecture", "users", "control_rate", "ratio", "sampling"):
        if options[name] is not None:
            raise InputError(
                f"--{name.replace('_', '-')} describes a loop that is no scenario's, which has its "
                "own: change the scenario instead, such as --set rates.network='64 Hz'."
            )
    named = [text for text in settings if not is_path(text)]
    written = read(file, overlays, [text for text in settings if is_path(text)])
    written = _with_delays(written, options)
    late = options["computation_delay"]
    if late is not None:
        written = _with_late_couplers(written, late)
    return RunLoop(
        file,
        written,
        tuple(read_setting(text) for text in named),
        None if options["at"] is None else _seconds(options["at"]),
        options["ideal"] is not False,
        4 if options["window"] is None else options["window"],
    )


def refuse_run_options(options: dict[str, Any]) -> None:
    """``--at`` and the like belong to a run.

    Raises:
        InputError: one was given without a scenario.
    """
    for name, word in (("at", "--at"), ("ideal", "--ideal or --as-is"), ("window", "--window")):
        if options[name] is not None:
            raise InputError(f"{word} is about a run: give --scenario FILE too.")


def is_path(text: str) -> bool:
    """Whether --set means something of the scenario, and no parameter by the thesis's name."""
    name = text.partition("=")[0].strip()
    return "." in name or name in TOP_LEVEL


def _with_delays(written: Written, options: dict[str, Any]) -> Written:
    forward, backward = options["forward_delay"], options["backward_delay"]
    given = {
        "round_trip_delay": options["round_trip_delay"],
        "each_way_delay": options["each_way_delay"],
        "delay": None
        if forward is None and backward is None
        else f"{{forward: {forward or 0}, backward: {backward or 0}}}",
    }
    asked = {form: value for form, value in given.items() if value is not None}
    if not asked:
        return written
    if len(asked) > 1:
        raise InputError(
            "Give the delay in one form only: --round-trip-delay, --each-way-delay, or "
            "--forward-delay with --backward-delay."
        )
    form, value = asked.popitem()
    channels = written.built().channels
    if not channels:
        raise InputError(
            "The scenario has no channel, so that there is no delay to change: leave it out, or "
            "take --computation-delay."
        )
    sets: list[str] = []
    for channel in channels:
        sets += [f"channels.{channel}.{other}=~" for other in given]
        sets.append(f"channels.{channel}.{form}={value}")
    return written.changed(sets)


def _with_late_couplers(written: Written, ticks: int) -> Written:
    scenario = written.built()
    parts = [
        name
        for name, part in scenario.components.items()
        if part.is_bundled and part.source in {"virtual_coupler", "pantograph"}
    ]
    if not parts:
        raise InputError(
            "The scenario has neither virtual couplers nor pantographs, which alone have a "
            "computation delay: leave --computation-delay out."
        )
    return written.changed(
        [f"components.{name}.parameters.computation_delay_ticks={ticks}" for name in parts]
    )


def _seconds(text: str) -> Fraction:
    try:
        return quantity(text, "s")
    except QuantityError as error:
        raise InputError(f"--at {text}: {error}") from None
