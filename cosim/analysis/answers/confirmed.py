"""A design's corners in the simulation: the real kernel's own map, gains and all."""

from __future__ import annotations

from cosim.analysis.answers.asked import ask
from cosim.analysis.answers.chance import with_losses
from cosim.analysis.answers.vary import deciding_radius
from cosim.analysis.single_axis import paths_of_leaves
from cosim.base.errors import InputError
from cosim.scenario.load import read
from cosim.theory.chance.network import Network
from cosim.theory.design.corners import Corner, corners_of
from cosim.theory.design.search import Design
from cosim.theory.models.parameters import Parameters
from cosim.theory.models.timing import PathDelay


def confirmed(
    parameters: Parameters, network: Network, found: Design, margin: float
) -> dict[str, float]:
    """The radius in every corner of the run of the bundled single-axis scenario, by name.

    Raises:
        InputError: there are more than two users, for whom no scenario is bundled, or a
            parameter that none has.
    """
    if parameters.users != 2:
        raise InputError("Designs are confirmed in the bundled scenarios, which have two users.")
    if found.timing.computation_delay and parameters["b_w"]:
        raise InputError(
            "An object's wall has no computation delay in a run, and that of the loop has the "
            "couplers': confirm without the wall, or without the delay."
        )
    resolved = parameters.replaced(found.gains | {"b_c": found.compensation})
    _refuse_what_no_run_has(resolved)
    return {
        corner.name: _radius(resolved, network, found, corner)
        for corner in corners_of(parameters, network, margin)
    }


def _refuse_what_no_run_has(parameters: Parameters) -> None:
    paths = paths_of_leaves(read(f"single_axis_{parameters.architecture}").built())
    for leaf in parameters.leaves:
        if leaf not in paths and parameters[leaf] != 0.0:
            raise InputError(
                f"The bundled scenarios have nothing that {leaf} could be: confirm without it."
            )


def _radius(parameters: Parameters, network: Network, found: Design, corner: Corner) -> float:
    name = f"single_axis_{parameters.architecture}"
    control, period = 1 / found.timing.control_period, found.timing.network_period
    delay = corner.timing(found.timing).delay
    late = corner.loses and network.jitter > 0
    if late:  # each packet draws its delay, all of it
        delay = PathDelay()
    sets = [
        f"rates.control={control} Hz",
        f"rates.network={1 / period} Hz",
        *(f"channels.lan.{form}=~" for form in ("round_trip_delay", "each_way_delay")),
        f"channels.lan.delay={{forward: {delay.forward}, backward: {delay.backward}}}",
        "components.step_1.parameters.amplitude=0",
    ]
    if late:
        sets.append(f"channels.lan.jitter={{weights: {network.delay_probabilities()}}}")
        sets.append(f"channels.lan.loss={network.loss!r}")
    written = read(name, (), sets)
    leaves = paths_of_leaves(written.built())
    ticks = found.timing.computation_delay
    couplers = [
        part for part in written.built().components.values() if part.source == "virtual_coupler"
    ]
    written = written.changed(
        [f"components.{part.name}.parameters.computation_delay_ticks={ticks}" for part in couplers]
    )
    paths = [
        f"{path}={parameters[leaf] * _factor(corner, leaf)!r}"
        for leaf in parameters.leaves
        for path in leaves.get(leaf, ())
    ]
    with ask(written.changed(paths)) as asked:
        point = asked.point()
        if late:
            return deciding_radius(point)
        if not corner.loses:
            return point.spectrum().radius
        return with_losses(point).radius(network.loss) ** 0.5


def _factor(corner: Corner, leaf: str) -> float:
    """What a corner makes of a parameter; an absent hand is one that nothing ties to the object."""
    if leaf.startswith("m_"):
        return corner.hand_mass if leaf.startswith("m_h") else corner.object_mass
    if leaf.startswith(("b_c", "k_w", "b_w")):
        return 1.0
    hand = leaf[3:] if leaf[2:3].isdigit() and len(leaf) == 4 else leaf[2:]
    if corner.present is not None and hand.isdigit() and not corner.present[int(hand) - 1]:
        return 0.0
    return corner.stiffness if leaf[0] == "k" else corner.damping
