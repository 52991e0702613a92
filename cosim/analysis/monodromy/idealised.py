"""The scenario without what has no derivative, by one switch, and the sentence that says so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cosim.analysis.parameter import layout_of
from cosim.scenario import Scenario, ScenarioComponent
from cosim.scenario.load import Written

WINDOW = 4
"""Ticks over which a finite difference stands for FOAW unless another is asked for."""


@dataclass(frozen=True, slots=True)
class Idealised:
    """A scenario as the theory takes it.

    Attributes:
        written: to be changed further.
        notes: what was left out, for people.
    """

    written: Written
    notes: tuple[str, ...]


def idealised(written: Written, scenario: Scenario, window: int = WINDOW) -> Idealised:
    """Encoders, DACs, dry friction and FOAW taken out where the scenario has them."""
    sets: list[str] = []
    left_out: dict[str, None] = {}
    for name, part in scenario.components.items():
        if not part.is_bundled:
            continue
        ideal = layout_of(part.source).model.ideal
        for parameter, value in ideal.items():
            if parameter.startswith("velocity_"):
                continue
            sets.append(f"components.{name}.parameters.{parameter}={value}")
            left_out[_SAID[parameter]] = None
        if "velocity_estimator" in ideal and estimates_adaptively(part):
            sets.append(f"components.{name}.parameters.velocity_estimator=finite_difference")
            sets.append(f"components.{name}.parameters.velocity_window={window}")
            left_out[f"FOAW, for which a difference over {window} ticks stands"] = None
    if not sets:
        return Idealised(written, ())
    listed = ", ".join(left_out)
    note = f"Ideal: without {listed}. With them the run may rest where this one would not."
    return Idealised(written.changed(sets), (note,))


def damped(written: Written, scenario: Scenario) -> Written:
    """The scenario that comes to rest where this one would, if it did."""
    sets = [
        f"components.{name}.parameters.{parameter}={value}"
        for name, part in scenario.components.items()
        if part.is_bundled
        for parameter, value in layout_of(part.source).model.damped.items()
    ]
    return written.changed(sets)


_SAID: Mapping[str, str] = {
    "encoder_counts": "encoder counts",
    "dac_bits": "DAC codes",
    "coulomb_friction": "dry friction of the joints",
    "ground_friction": "dry friction of the ground",
    "ground_rotational_friction": "dry friction of the ground",
}


def estimates_adaptively(part: ScenarioComponent) -> bool:
    """Whether a workstation estimates velocities by FOAW."""
    return part.parameters.get("velocity_estimator", "foaw") in {"foaw", 0}
