"""Trace: recorded fates of packets, in place of delay, jitter and loss."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import Discriminator, Field, Tag

from cosim.base.errors import InputError, Location
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.scenario.form.fields import Lag, Packet
from cosim.scenario.impairments.effect import LOST, Average, Draw, Effect, PacketBlock
from cosim.scenario.impairments.impairment import Impairment, ImpairmentProblem, Setting


def _tag(value: Any) -> str:
    return "inline" if isinstance(value, list) else "file"


@dataclass(frozen=True, slots=True)
class Trace(Effect):
    """The recorded fate of each packet in order, repeated when it ends."""

    order: ClassVar[int] = 0
    own_key: ClassVar[bool] = False
    remembers: ClassVar[bool] = False

    fates: tuple[int, ...]
    """Delays (ticks), ``LOST`` where a packet never arrives; at least one."""
    file: Path | None = field(default=None, compare=False)
    """Where it was read from, if it was a file."""

    @property
    def _came(self) -> list[int]:
        return [delay for delay in self.fates if delay != LOST]

    def write(self, period: int) -> str | list[str]:
        """The file, or every fate."""
        if self.file is not None:
            return str(self.file)
        written = {LOST: "lost", 1: "1 tick"}
        return [written.get(ticks, f"{ticks} ticks") for ticks in self.fates]

    def describe(self) -> int:
        """Number of packets."""
        return len(self.fates)

    def sentence(self) -> str:
        """Number of packets."""
        return f"trace of {len(self.fates)} packets"

    def range(self, shortest: int, longest: int) -> tuple[int, int]:
        """Of the packets that came."""
        return min(self._came, default=1), max(self._came, default=0)

    def draw(self, key: int) -> Draw:
        """Nothing is drawn: packet n has fate n, modulo their number."""
        import numpy as np

        fates = np.array(self.fates, dtype=np.int64)

        def repeat(packets: PacketBlock) -> None:
            numbers = np.arange(packets.first, packets.first + packets.count)
            packets.delays[:] = fates[numbers % len(fates)]

        return repeat

    def average(self, before: Average) -> Average:
        """Over the packets of the trace."""
        came = self._came
        if not came:
            return Average(0.0, 0.0, 1.0)
        mean = sum(came) / len(came)
        variance = sum((delay - mean) ** 2 for delay in came) / len(came)
        return Average(mean, variance, 1.0 - len(came) / len(self.fates))


def _resolve(written: Any, setting: Setting) -> Trace:
    if not isinstance(written, str):
        lags: list[Lag | None] = written
        return Trace(tuple(LOST if lag is None else setting.ticks(lag) for lag in lags))
    file = (setting.folder() / Path(written).expanduser()).resolve()
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "it is no UTF-8 text"
        raise ImpairmentProblem(f"cannot read {written}: {reason}.") from None
    fates = [
        _fate(line.strip(), Location(str(file), number, 1), setting)
        for number, line in enumerate(lines, start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not fates:
        raise ImpairmentProblem(f"{written} has no packet in it.")
    return Trace(tuple(fates), file)


def _fate(line: str, place: Location, setting: Setting) -> int:
    if line == "lost":
        return LOST
    try:
        seconds = quantity(line, "s")
    except QuantityError:
        seconds = Fraction(-1)
    if not 0 <= seconds <= 3600:
        raise InputError(f"'{line[:40]}' is neither 'lost' nor a delay of 0 to 3600 s.", place)
    return setting.timebase.ticks(seconds)


TRACE = Impairment(
    name="trace",
    description="Recorded delays, in place of delay, jitter and loss: a list, or a file with a "
    "delay in seconds or `lost` in each line.",
    form=Annotated[
        Annotated[str, Tag("file")]
        | Annotated[list[Packet], Field(min_length=1, max_length=10_000_000), Tag("inline")],
        Discriminator(_tag),
    ],
    resolve=_resolve,
    replaces=("delay", "jitter", "loss"),
)
