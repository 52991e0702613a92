"""The fingers that stations tell of in a recorded run, found by what its signals mean."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError
from cosim.base.meaning import Meaning, Slot
from cosim.base.quantities.units import conversion, unit_of
from cosim.base.suggest import did_you_mean
from cosim.scenario import Kind

if TYPE_CHECKING:
    from pathlib import Path

    from cosim.base.component import Variable
    from cosim.record.reader import Run
    from cosim.record.signals import RecordedSignal
    from cosim.scenario import Scenario, ScenarioComponent

    Place: TypeAlias = tuple[str, Slot]
    """A component and which of its fingers."""

AXES = (
    (Meaning.TOLD_X, Meaning.TOLD_VELOCITY_X),
    (Meaning.TOLD_Y, Meaning.TOLD_VELOCITY_Y),
)
_UNITS = dict(zip((each for axis in AXES for each in axis), ("m", "m/s", "m", "m/s"), strict=True))


@dataclass(frozen=True, slots=True)
class ToldFinger:
    """One finger as its station tells of it, under the name ``component.finger_number``."""

    component: str
    name: str
    signals: Mapping[Meaning, RecordedSignal]

    @property
    def rate(self) -> Fraction:
        """Rows a second (Hz)."""
        return self.signals[Meaning.TOLD_X].group.rate

    def moves(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions (m) and velocities (m/s), each of shape (rows, 2).

        Raises:
            InputError: a value is no number.
        """
        first, second = (
            np.stack([_values(self.signals[axis[order]]) for axis in AXES], axis=1)
            for order in (0, 1)
        )
        return first, second


def told_fingers(run: Run, wanted: Sequence[str] = ()) -> list[ToldFinger]:
    """The fingers whose position and velocity stations send: all, or those that are named.

    Raises:
        InputError: there is none, one of them is not there as a whole, two signals mean the same,
            or their rates differ.
    """
    found = {finger.name: finger for finger in _fingers(run)}
    for name in wanted:
        if name not in found:
            raise InputError(
                f"{run.folder} has no finger '{name}'.{did_you_mean(name, found)}"
                f" There are {', '.join(found)}."
            )
    chosen = [found[name] for name in wanted or found]
    signals = [signal for finger in chosen for signal in finger.signals.values()]
    odd = next((each for each in signals if each.group.rate != signals[0].group.rate), None)
    if odd is not None:
        raise InputError(
            f"{run.folder}: {odd.name} is recorded at {float(odd.group.rate):g} Hz and "
            f"{signals[0].name} at {float(signals[0].group.rate):g} Hz: record all that is told "
            "of fingers at one rate, or choose those of one rate with --finger."
        )
    return chosen


def packet_rate(scenario: Scenario, fingers: Sequence[ToldFinger], folder: Path) -> Fraction:
    """How often packets with these fingers were sent (Hz), as the run's channels say.

    Raises:
        InputError: no channel carries them, or several of different rates.
    """
    tellers = {finger.component for finger in fingers}
    rates = {
        each.via: scenario.channels[each.via].rate
        for each in scenario.connections
        if each.via is not None and each.source.component in tellers
    }
    if not rates:
        raise InputError(
            f"{folder}: no channel carries what {', '.join(sorted(tellers))} tell of fingers: say "
            "with --network-rate how often packets are to be sent."
        )
    if len(set(rates.values())) > 1:
        each = ", ".join(f"{name} at {float(rate):g} Hz" for name, rate in rates.items())
        raise InputError(
            f"{folder}: what is told of fingers crosses channels of several rates, {each}: choose "
            "one with --network-rate."
        )
    return next(iter(rates.values()))


def predicting(scenario: Scenario, folder: Path, numbers: Sequence[str]) -> dict[str, str]:
    """The components that can guess a peer's intent: name -> their predictor parameter's name.

    ``numbers`` are those that ``intent`` has to take.

    Raises:
        InputError: there is none, or a file of one is not there.
    """
    found: dict[str, str] = {}
    for name, part in scenario.components.items():
        variables = _variables(part)
        for variable in variables.values():
            if (
                variable.meaning_of() is Meaning.PREDICTOR
                and "intent" in (variable.items or {})
                and all(f"intent.{number}" in variables for number in numbers)
            ):
                found[name] = variable.name
    if not found:
        raise InputError(
            f"{folder}: none of its components has a parameter that means "
            f"'{Meaning.PREDICTOR}' and can be 'intent', so there is nothing to write with --out."
        )
    return found


def _fingers(run: Run) -> Iterator[ToldFinger]:
    there: dict[Place, dict[Meaning, RecordedSignal]] = {}
    for name, signal in run.signals.items():
        meaning = signal.meaning
        if meaning is None or meaning not in _UNITS:
            continue
        finger = there.setdefault((name.partition(".")[0], signal.belongs_to), {})
        if meaning in finger:
            raise InputError(
                f"{run.folder} has several signals that mean '{meaning}' of "
                f"{_name(name.partition('.')[0], signal.belongs_to)}, {finger[meaning].name} and "
                f"{name}: leave all but one of them out of 'record'."
            )
        finger[meaning] = signal
    if not there:
        raise InputError(
            f"{run.folder} has no signal that means '{Meaning.TOLD_X}', which is where a station "
            "tells its peers that a finger is: record what stations send, such as vr_a.shared; "
            "what was run before signals said this has to be run again."
        )
    for (component, slot), signals in there.items():
        missing = [each for each in _UNITS if each not in signals]
        if missing:
            given = next(iter(signals.values()))
            raise InputError(
                f"{run.folder} has {given.name} of {_name(component, slot)}, and no signal that "
                f"means its '{missing[0]}': record all that {component} tells of it."
            )
        yield ToldFinger(component, _name(component, slot), signals)


def _name(component: str, slot: Slot) -> str:
    return component if slot.finger is None else f"{component}.finger_{slot.finger}"


def _values(signal: RecordedSignal) -> NDArray[np.float64]:
    meaning = signal.meaning
    assert meaning is not None, "it was found by it"
    unit = signal.unit or _UNITS[meaning]
    converted = conversion(unit_of(unit), unit_of(_UNITS[meaning]))
    if converted is None:
        raise InputError(
            f"{signal.name} means '{meaning}' and is in {unit}, which is no {_UNITS[meaning]}: its "
            "component declares one of them wrongly."
        )
    factor, offset = converted
    values = factor * np.asarray(signal.values, dtype=np.float64) + offset
    unknown = int(np.sum(~np.isfinite(values)))
    if unknown:
        raise InputError(
            f"{signal.name}: {unknown} of its {len(values)} values are no numbers, so that nothing "
            "can be fitted to it. Choose other fingers with --finger."
        )
    return values


def _variables(part: ScenarioComponent) -> Mapping[str, Variable]:
    """What an FMU declares; other kinds of components guess nothing."""
    from pathlib import Path

    import fmus
    from cosim.master.fmu.reading import read_description

    if part.kind is not Kind.FMU:
        return {}
    file = fmus.find(part.source, part.flavour) if part.is_bundled else Path(part.source)
    return read_description(file).variables
