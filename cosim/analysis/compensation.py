"""``compensation: auto`` of a distributed workstation: the b_c that nulls the network's damping.

Each copy of the box gets the same b_c, computed at the scenario's own rates and delay:

- ``auto``: along x and y the original model of section 6.1 with one finger a user on the normal
  couplers, everyone holding the box; in rotation the simplified model. It cancels what users feel
  while they all hold on, and is too much for a box that nobody holds.
- ``cautious``: the simplified model on all axes. It cancels less, and never drives a free box.

A delay between two samples is taken to the tick by ``auto``, and rounded down by ``cautious``.
Loss, jitter and reordering make what is held older than the delay does, so that less is cancelled
than is felt. What the models do not have is refused: prediction, a recorded trace, and for ``auto``
ways of unlike delays.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean

if TYPE_CHECKING:
    from cosim.analysis.grasp import Grasp
    from cosim.scenario import Scenario
    from cosim.scenario.form.sections import Forms
    from cosim.scenario.load import Written
    from cosim.theory.models.timing import Timing
    from cosim.theory.transparency.damping import DampingModel

CHOICES = ("auto", "cautious")


def load_tuned(
    path: str | PathLike[str],
    overlays: Sequence[str | PathLike[str]] = (),
    sets: Sequence[str] = (),
    *,
    forms: Forms | None = None,
) -> Scenario:
    """Load a scenario and put numbers in place of every ``compensation: auto``.

    The numbers are in the resolved scenario, as if they had been written.

    Raises:
        InputError: as :func:`cosim.scenario.load`, or the theory cannot tell the compensation.
    """
    from cosim.scenario.load import read

    return tuned_scenario(read(path, overlays, sets, forms=forms))


def tuned(written: Written) -> Written:
    """What is written, with numbers in place of every ``compensation: auto``.

    Raises:
        InputError: as for ``load_tuned``.
    """
    numbers = _numbers(written.built())
    return written.changed(numbers) if numbers else written


def tuned_scenario(written: Written) -> Scenario:
    """The checked scenario of ``tuned``.

    Raises:
        InputError: as for ``load_tuned``.
    """
    scenario = written.built()
    numbers = _numbers(scenario)
    return written.changed(numbers).built() if numbers else scenario


def _numbers(scenario: Scenario) -> list[str]:
    """The overrides that give numbers in place of words."""
    wanted = {
        name: str(part.parameters["compensation"])
        for name, part in scenario.components.items()
        if isinstance(part.parameters.get("compensation"), str)
    }
    if not wanted:
        return []
    from cosim.analysis.grasp import WORKSTATION, find_grasp
    from cosim.analysis.left_out import refuse_other_peers

    for name, choice in wanted.items():
        place = scenario.locate(("components", name, "parameters", "compensation"))
        if choice not in CHOICES:
            hint = did_you_mean(choice, CHOICES)
            raise InputError(
                f"compensation is {{x, y, theta}}, auto or cautious, not '{choice}'.{hint}", place
            )
        if scenario.components[name].source != WORKSTATION:
            raise InputError(
                f"compensation: {choice} is for a distributed_workstation; the network damps no "
                "other model's box.",
                place,
            )
    grasp = find_grasp(scenario, earliest=True)
    refuse_other_peers(scenario, grasp.workstations)
    if "auto" in wanted.values():
        find_grasp(scenario)  # which has one delay each way
    found = {choice: _compensation(grasp, choice) for choice in set(wanted.values())}
    numbers: list[str] = []
    for name, choice in wanted.items():
        parameter = f"components.{name}.parameters.compensation"
        numbers.append(f"{parameter}=~")
        numbers += [f"{parameter}.{axis}={b_c!r}" for axis, b_c in found[choice].items()]
    return numbers


def _compensation(grasp: Grasp, choice: str) -> dict[str, float]:
    """b_c along x and y (N·s/m) and in rotation (N·m·s/rad)."""
    if choice == "cautious":
        return _nulling(grasp, grasp.timing, "simplified")
    return _nulling(grasp, grasp.timing.delayed(*grasp.ways), "original")


def _nulling(grasp: Grasp, timing: Timing, kind: DampingModel) -> dict[str, float]:
    from cosim.theory.transparency.compensation import null_compensation

    linear = null_compensation(grasp.model("normal"), timing, 0, kind).value
    rotation = null_compensation(grasp.model("rotation"), timing, 0, "simplified").value
    return {"x": linear, "y": linear, "theta": rotation}
