"""An impairment as a scenario's language sees it: its key, its form, and how it is resolved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from cosim.scenario.impairments.effect import Effect

if TYPE_CHECKING:
    from cosim.scenario.build.timebase import Timebase
    from cosim.scenario.form.fields import Lag


class ImpairmentProblem(ValueError):
    """What is written cannot be used; the text says why, from its place on."""


@dataclass(frozen=True, slots=True)
class Setting:
    """What an impairment is resolved with: the channel's time and the place of its file."""

    timebase: Timebase
    period: int
    """Base ticks in one sample of the channel."""
    folder: Callable[[], Path]
    """The folder that a relative file starts from."""

    @property
    def base_rate(self) -> Fraction:
        """Base ticks a second (Hz)."""
        return self.timebase.base_rate

    def ticks(self, lag: Lag) -> int:
        """A written delay in base ticks."""
        return self.timebase.delay(lag, self.period).ticks


@dataclass(frozen=True, slots=True, kw_only=True)
class Dial:
    """How an impairment is turned by one number while a scenario runs."""

    unit: Literal["s", "1"]
    """``s``: a time in base ticks, rounded up. ``1``: a probability."""
    description: str
    read: Callable[[Effect | None, Fraction], float]
    """The number that an effect stands for, at a base rate (Hz).

    Raises ``ImpairmentProblem`` for one that is more than a number.
    """
    turn: Callable[[Effect | None, float, Fraction], Effect | None]
    """The effect with another number, at a base rate (Hz); ``None`` where it does nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Impairment:
    """One key of a channel, registered in ``registry.py`` or by an entry point.

    It may be written once for both directions or as ``{forward: …, backward: …}``; ``form`` is the
    pydantic type of what is written for one. ``resolve`` gets a value of that type and gives the
    effect, ``None`` where it does nothing.
    """

    name: str
    description: str
    """For the editor's schema: one sentence."""
    form: Any
    resolve: Callable[[Any, Setting], Effect | None]
    """Raises ``ImpairmentProblem`` or a located ``InputError`` for what cannot be used."""
    replaces: tuple[str, ...] = ()
    """Keys of a channel that this stands in place of, ``delay`` for each form of delay."""
    absent: Any = None
    """What says that there is none, in a resolved scenario and for programs; ``None``: nothing."""
    dial: Dial | None = None
    """How it is turned while a scenario runs; ``None``: it stays as it is."""
