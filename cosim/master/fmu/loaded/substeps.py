"""How many steps an FMU takes in one period of its component."""

from __future__ import annotations

from cosim.master.assembly.clock import Clock
from cosim.master.fmu.description import FmuDescription
from cosim.scenario.build.timebase import hertz


def choose_substeps(
    description: FmuDescription, clock: Clock, period: int, asked: int
) -> tuple[int, str]:
    """How many equal steps the FMU takes in one period, and a note where it prefers others.

    An FMU that cannot vary its step takes the step that it was made for, as often as it fits;
    where that does not fit, steps of another length, which are legal as long as all are equal
    (FMI 2.0.4 section 4.3.1, ``canHandleVariableCommunicationStepSize``).
    """
    fixed = description.fixed_step
    if fixed is None or asked > 1:
        return asked, ""
    whole = period * clock.tick
    ratio = whole / fixed
    if ratio.denominator == 1:
        return ratio.numerator, ""
    nearest = sorted({max(1, int(ratio)), int(ratio) + 1})
    rates = " or ".join(hertz(1 / (count * fixed)) for count in nearest)
    return asked, (
        f"the FMU {description.path.name} was made for steps of {float(fixed):g} s, which do not "
        f"divide its period; all its steps are {float(whole):g} s long (a rate of {rates} would "
        "give it its own)"
    )
