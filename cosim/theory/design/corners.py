"""The corners of a design: what may be otherwise than it was designed for, one thing at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cosim.theory.chance.mean_square import is_mean_square_stable, mean_square_radius
from cosim.theory.chance.network import Network
from cosim.theory.chance.packets import LinkProcess
from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.parameters import Parameters
from cosim.theory.models.timing import Timing
from cosim.theory.stability.margins import scaled
from cosim.theory.stability.spectral_radius import stability
from cosim.theory.transparency.damping import uniform_compensation

EDGE = 1.0 - 1e-12


@dataclass(frozen=True, slots=True)
class Corner:
    """One way in which reality may differ.

    Attributes:
        name: for people.
        stiffness: factor on every coupler's stiffness.
        damping: factor on every coupler's damping.
        hand_mass: factor on every hand's mass.
        object_mass: factor on the object's mass.
        delay: samples more or less, forward and backward.
        present: whose hands hold the object; None: everyone's.
        loses: packets are lost and late as the network says.
    """

    name: str
    stiffness: float = 1.0
    damping: float = 1.0
    hand_mass: float = 1.0
    object_mass: float = 1.0
    delay: tuple[int, int] = (0, 0)
    present: tuple[bool, ...] | None = None
    loses: bool = False

    def model(self, parameters: Parameters, compensation: float) -> Model:
        """The loop in this corner; what compensates does not change with it."""
        found = scaled(parameters.model(self.present), self.stiffness, self.damping)
        found = replace(
            found,
            hand_mass=found.hand_mass * self.hand_mass,
            object_mass=found.object_mass * self.object_mass,
        )
        return uniform_compensation(found, compensation)

    def timing(self, timing: Timing) -> Timing:
        """The rates, and the delay in this corner."""
        forward, backward = self.delay
        delay = timing.delay
        later = replace(delay, forward=delay.forward + forward, backward=delay.backward + backward)
        return replace(timing, delay=later)


def corners_of(parameters: Parameters, network: Network, margin: float) -> tuple[Corner, ...]:
    """Every corner that a design of a margin m is promised to stand.

    Stiffness and damping times 1 ± m, each and both; masses times 1 ± m; a sample of delay more
    and less (less each way where the delay was rounded up); any fewer hands, and none; and the
    network's loss and jitter, also with stiffness and damping times 1 + m.
    """
    more, less = 1.0 + margin, max(1.0 - margin, 0.05)
    percent = f"{100 * margin:g} %"
    found = [Corner("as designed")]
    signs = {"+": more, "−": less, "": 1.0}
    if margin > 0:
        for k_sign, k in signs.items():
            for b_sign, b in signs.items():
                words = [
                    f"{what} {sign}{percent}"
                    for what, sign in (("stiffness", k_sign), ("damping", b_sign))
                    if sign
                ]
                if words:
                    found.append(Corner(", ".join(words), stiffness=k, damping=b))
        for sign, factor in (("+", more), ("−", less)):
            found.append(Corner(f"hand mass {sign}{percent}", hand_mass=factor))
            found.append(Corner(f"object mass {sign}{percent}", object_mass=factor))
    samples = network.fixed_delay
    found.append(Corner("a sample of delay more", delay=(1, 0)))
    if samples > 0:
        found.append(Corner("a sample of delay less", delay=(-1, 0)))
        if network.delay < samples * float(network.period) * (1 - 1e-9):
            found.append(Corner("a sample of delay less each way", delay=(-1, -1)))
    users = parameters.users
    for holding in range(1, users):
        hands = tuple(m < holding for m in range(users))
        found.append(Corner(_held_by(hands), present=hands))
        if parameters.architecture == "centralized":
            others = (False, *(m < holding for m in range(users - 1)))
            found.append(Corner(_held_by(others), present=others))
    found.append(Corner("nobody holds it", present=(False,) * users))
    if network.loss > 0 or network.jitter > 0:
        found.append(Corner("loss and jitter", loses=True))
        if margin > 0:
            name = f"loss and jitter, stiffness and damping +{percent}"
            found.append(Corner(name, stiffness=more, damping=more, loses=True))
    return tuple(found)


def _held_by(hands: Sequence[bool]) -> str:
    names = [str(number) for number, held in enumerate(hands, start=1) if held]
    return f"held by user {' and '.join(names)} alone"


def radius_in(
    corner: Corner,
    parameters: Parameters,
    timing: Timing,
    process: LinkProcess,
    compensation: float,
) -> float:
    """The spectral radius in a corner; of the second moments, its root, where packets are lost."""
    model, clock = corner.model(parameters, compensation), corner.timing(timing)
    if corner.loses:
        return mean_square_radius(model, clock, lambda _: process) ** 0.5
    return stability(model, clock).spectral_radius


def stands(
    corner: Corner,
    parameters: Parameters,
    timing: Timing,
    process: LinkProcess,
    compensation: float,
) -> bool:
    """Whether the loop is stable in a corner."""
    if not corner.loses:
        return radius_in(corner, parameters, timing, process, compensation) < EDGE
    model, clock = corner.model(parameters, compensation), corner.timing(timing)
    return is_mean_square_stable(model, clock, lambda _: process, edge=EDGE**2)
