"""A design's corners in the simulation: the real kernel's own map, gains and all."""

from __future__ import annotations

from cosim.analysis.answers.asked import ask
from cosim.analysis.answers.chance import with_losses
from cosim.analysis.single_axis import paths_of_leaves
from cosim.base.errors import InputError
from cosim.scenario.load import read
from cosim.theory.chance.network import Network
from cosim.theory.design.corners import Corner, corners_of
from cosim.theory.design.search import Design
from cosim.theory.models.parameters import Parameters


def confirmed(
    parameters: Parameters, network: Network, found: Design, margin: float
) -> dict[str, float]:
    """The radius in every corner of the run of the bundled single-axis scenario, by name.

    Jitter is left to the theory.

    Raises:
        InputError: there are more than two users, for whom no scenario is bundled.
    """
    if parameters.users != 2:
        raise InputError("Designs are confirmed in the bundled scenarios, which have two users.")
    resolved = parameters.replaced(found.gains | {"b_c": found.compensation})
    return {
        corner.name: _radius(resolved, network, found, corner)
        for corner in corners_of(parameters, network, margin)
        if not (corner.loses and network.jitter > 0)
    }


def _radius(parameters: Parameters, network: Network, found: Design, corner: Corner) -> float:
    name = f"single_axis_{parameters.architecture}"
    control, period = 1 / found.timing.control_period, found.timing.network_period
    delay = corner.timing(found.timing).delay
    sets = [
        f"rates.control={control} Hz",
        f"rates.network={1 / period} Hz",
        *(f"channels.lan.{form}=~" for form in ("round_trip_delay", "each_way_delay")),
        f"channels.lan.delay={{forward: {delay.forward}, backward: {delay.backward}}}",
        "components.step_1.parameters.amplitude=0",
    ]
    written = read(name, (), sets)
    leaves = paths_of_leaves(written.built())
    paths = [
        f"{path}={parameters[leaf] * _factor(corner, leaf)!r}"
        for leaf in parameters.leaves
        for path in leaves.get(leaf, ())
    ]
    with ask(written.changed(paths)) as asked:
        point = asked.point()
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
