"""``cohaptic run model.fmu``: the scenario of one FMU alone, from what its description says."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Sequence
from fractions import Fraction
from math import ceil, gcd, lcm
from pathlib import Path
from typing import TYPE_CHECKING

from cosim.base.document.plain_name import plain_name
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean

if TYPE_CHECKING:
    from cosim.master.fmu.description import FmuDescription
    from cosim.scenario import Scenario

DESCRIPTION = "modelDescription.xml"
_STEPS = 500
"""Of a run whose FMU does not say how long its steps are."""


def is_fmu(given: str | None) -> bool:
    """Whether what was given to ``run`` is an FMU's file, or the folder of one that is unpacked."""
    if given is None:
        return False
    path = Path(given).expanduser()
    return path.suffix.casefold() == ".fmu" or (path / DESCRIPTION).is_file()


def scenario_of_fmu(
    given: str,
    *,
    stop_time: str | None,
    step_size: str | None,
    sets: Sequence[str],
    say: Callable[[str], None] = lambda _: None,
) -> Scenario:
    """A scenario with the FMU as its only component.

    Its default experiment says when it starts, and when it stops and in which steps where that is
    not given. A name in
    ``sets`` that is one of the FMU's variables is a parameter or a start value of it. ``say`` is
    told where the run ends a part of a step later.

    Raises:
        InputError: it cannot be read, nobody says how long to run, or an override leads nowhere.
    """
    from cosim.base.document.yaml_reader import parse_yaml
    from cosim.base.document.yaml_writer import write_yaml
    from cosim.master.fmu.reading import read_description
    from cosim.reading import FORMS
    from cosim.scenario.load import Written

    path = Path(given).expanduser().absolute()
    description = read_description(path)
    begin, sets = begin_of(sets, description.variables)
    start = begin if begin is not None else description.start_time or Fraction(0)
    duration = _stop(description, path, stop_time) - start
    if duration <= 0:
        raise InputError(
            f"the FMU {path} starts at {float(start):g} s"
            f"{' (its default experiment)' if begin is None else ''} and would stop at "
            f"{float(start + duration):g} s; give a later --stop-time, or --set start_time=0"
        )
    step = seconds(step_size, "--step-size") if step_size is not None else description.step_size
    if step is None:
        step = _step(start, duration)
    if step > duration:
        raise InputError(
            f"a step of {float(step):g} s is longer than the {float(duration):g} s that the FMU "
            f"{path} is to run; give a shorter --step-size"
        )
    if rest := duration % step:
        say(
            f"note: {float(duration):g} s are no whole number of steps of {float(step):g} s; the "
            f"run ends at {float(start + duration - rest + step):g} s"
        )
    name = plain_name(path.stem) or "model"
    document = {
        "cohaptic": 1,
        "name": name,
        "title": f"{path.name} alone",
        "duration": str(duration),
        **({"start_time": str(start)} if start else {}),
        "components": {name: {"fmu": str(path), "rate": str(1 / step), "feedthrough": True}},
    }
    root = parse_yaml(write_yaml(document), str(path), has_lines=False)
    written = Written(path, root, FORMS)
    for text in sets:
        keys, value = _placed(text, name, description)
        written = written.with_value(keys, value, text) if keys else written.changed((text,))
    return written.built()


def begin_of(
    sets: Sequence[str], taken: Container[str] = ()
) -> tuple[Fraction | None, Sequence[str]]:
    """When it is to begin (s), where an override says so, and the other overrides.

    It is none where ``start_time`` is a name that is ``taken``.

    Raises:
        InputError: it says no time.
    """
    from cosim.base.quantities.quantity import QuantityError, quantity, simple

    begin, others = None, list[str]()
    for text in sets:
        key, _, value = text.partition("=")
        if key.strip() != "start_time" or "start_time" in taken:
            others.append(text)
            continue
        try:
            begin = simple(quantity(value, "s"))
        except QuantityError as error:
            raise InputError(f"--set {text}: {error}") from None
    return begin, others


def _step(start: Fraction, duration: Fraction) -> Fraction:
    """About as many as ``_STEPS``, of which both times are whole numbers."""
    both = lcm(start.denominator, duration.denominator)
    shared = Fraction(gcd(int(start * both), int(duration * both)), both)
    return shared / max(1, ceil(shared * _STEPS / duration))


def _stop(description: FmuDescription, path: Path, stop_time: str | None) -> Fraction:
    if stop_time is not None:
        return seconds(stop_time, "--stop-time")
    if description.stop_time is None:
        raise InputError(
            f"the FMU {path} does not say how long to run; give --stop-time, such as --stop-time 10"
        )
    return description.stop_time


def seconds(text: str, option: str) -> Fraction:
    """A time above 0 (s) that was given to an option.

    Raises:
        InputError: it is none.
    """
    from cosim.base.quantities.quantity import QuantityError, quantity, simple

    try:
        found = simple(quantity(text, "s"))
    except QuantityError as error:
        raise InputError(f"{option}: {error}") from None
    if found <= 0:
        raise InputError(f"{option} is a time above 0, not {text}.")
    return found


def _placed(text: str, name: str, description: FmuDescription) -> tuple[tuple[str, ...], str]:
    """Where in the scenario the variable stands that an override is for, and the value.

    Nowhere where it is for none. A variable's name may have anything in it, also ``=``.

    Raises:
        InputError: it is for no key of a scenario either.
    """
    from cosim.master.components.parameters import SETTABLE

    variables = {**description.variables, **{each.name: each for each in description.at_events}}
    parts = text.split("=")
    for used in range(len(parts) - 1, 0, -1):
        written = "=".join(parts[:used]).strip()
        variable = variables.get(written) or next(
            (v for key, v in variables.items() if key.startswith(f"{written}[")), None
        )
        if variable is not None:
            section = "parameters" if variable.causality in SETTABLE else "start"
            return ("components", name, section, written), "=".join(parts[used:])
    written = parts[0].strip()
    base = variables.get(written.partition("[")[0]) if written.endswith("]") else None
    if base is not None:  # an element, which is refused where arrays are known
        section = "parameters" if base.causality in SETTABLE else "start"
        return ("components", name, section, written), "=".join(parts[1:])
    _check_key(text, written, name, variables)
    return (), text


def _check_key(text: str, written: str, name: str, variables: Iterable[str]) -> None:
    """Refuse what is neither one of the FMU's variables nor a key of a scenario.

    Raises:
        InputError: with the nearest of both.
    """
    from cosim.scenario.form.document import Document

    known = {"include", *Document.model_fields}
    first = written.partition(".")[0]
    if written and first not in known and not first.startswith("x-"):
        raise InputError(
            f"--set {text}: the FMU {name} has no variable '{written}'."
            f"{did_you_mean(written, [*variables, *known], listed=0)}"
        )
