"""Perceived admittance of a user (6.1), by two definitions, and its inverse, the impedance.

*Frame-lifted* (6.1): the force is held over T_t and the velocity read at the start of the frame.
*Fundamental*: the force changes at every T_c, and of the periodic loop's response only the harmonic
at the force's own frequency counts. Above about 50 rad/s only the latter is what a hand feels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.models.assembly import assemble
from cosim.theory.models.frame import Frame
from cosim.theory.models.mass_spring_damper import Centralized, Model
from cosim.theory.models.parameters import TABLE_6_1, WALL, Architecture, Parameters
from cosim.theory.models.timing import Timing
from cosim.theory.models.zero_order_hold import zero_order_hold
from cosim.theory.numerics import Complex, Real, solve_complex
from cosim.theory.transparency.compensation import null_compensation

Case = Literal["free", "contact"]
"""``free``: velocity over force (Figs 6.2, 6.4). ``contact``: position over force (Fig. 6.5)."""

Felt = Literal["local", "remote", "distributed", "compensated", "ideal"]

ARCHITECTURE_OF: dict[str, Architecture] = {
    "local": "centralized",
    "remote": "centralized",
    "distributed": "distributed",
    "compensated": "distributed",
    "ideal": "distributed",
}


@dataclass(frozen=True, slots=True)
class Response:
    """A frequency response by both definitions: V/F in m/(N·s), or X/F in m/N in contact.

    Attributes:
        frequencies: shape (f,), rad/s.
        frame_lifted: shape (f,), complex.
        fundamental: shape (f,), complex.
        frame_limit: half the network rate in rad/s, above which the lifted response repeats.
    """

    frequencies: Real
    frame_lifted: Complex
    fundamental: Complex
    frame_limit: float

    def impedance(self, definition: Literal["frame_lifted", "fundamental"]) -> Complex:
        """Perceived impedance, the admittance's inverse: N·s/m, or N/m in contact; shape (f,)."""
        admittance = self.frame_lifted if definition == "frame_lifted" else self.fundamental
        return np.asarray(1.0 / admittance, dtype=np.complex128)


def perceived(
    parameters: Parameters, timing: Timing, felt: Felt, case: Case, frequencies: Real
) -> Response:
    """The admittance that one user feels while nobody else holds the object (Fig. 6.1).

    Args:
        parameters: of the architecture that ``felt`` belongs to; the wall is added in contact.
        timing: rates and delay.
        felt: who feels it; ``compensated`` is the distributed user with the b_c that nulls the
            damping in free motion at this delay (a b_c that was given is kept), ``ideal`` the hand
            and one object as one rigid mass.
        case: in free motion, or pressing the object against the wall.
        frequencies: rad/s, shape (f,), above 0.

    Raises:
        InputError: for frequencies that are not positive, or beyond the control rate's half.
    """
    if np.any(frequencies <= 0):
        raise InputError("Frequencies must be positive, in rad/s.")
    limit = np.pi / float(timing.control_period)
    if np.any(frequencies > limit):
        raise InputError(f"Frequencies must be below half the control rate, {limit:.6g} rad/s.")
    if felt == "compensated" and not {"b_c", "b_c1", "b_c2"} & parameters.given.keys():
        free = parameters.replaced({"k_w": 0.0, "b_w": 0.0}).model((True, False))
        null = null_compensation(free, timing, 0).value
        parameters = parameters.replaced({"b_c": null})
    if case == "contact":
        wall = {name: value for name, value in WALL.items() if name not in parameters.given}
        parameters = parameters.replaced(wall)
    if felt == "ideal":
        return _ideal(parameters, timing, case, frequencies)
    user = 1 if felt == "remote" else 0
    model = parameters.model(tuple(m == user for m in range(parameters.users)))
    return frequency_response(model, timing, user, case, frequencies)


def default_parameters(felt: Felt) -> Parameters:
    """Table 6.1 for the architecture that a user belongs to."""
    architecture = ARCHITECTURE_OF[felt]
    return Parameters(architecture, {}, TABLE_6_1[architecture])


def frequency_response(
    model: Model, timing: Timing, user: int, case: Case, frequencies: Real
) -> Response:
    """Both responses of a user's hand in a model.

    Args:
        model: the loop.
        timing: rates and delay; a whole ratio.
        user: whose hand is pushed and read, counted from 0.
        case: velocity over force, or position over force.
        frequencies: rad/s, shape (f,).
    """
    frame = assemble(model, timing).frame()
    station = user
    if isinstance(model, Centralized) and user > 0:
        station = 1 + sum(model.present[1:user])
    place = frame.hand[station]
    if place is None:
        raise InputError(f"User {user + 1} has no hand in this model, so feels nothing.")
    read = np.zeros(frame.tick.shape[0])
    read[place + (1 if case == "free" else 0)] = 1.0
    return _responses(frame, frame.force_on_hand[station], read, frequencies)


def _responses(frame: Frame, push: Real, read: Real, frequencies: Real) -> Response:
    n, m = frame.map.shape[0], frame.tick.shape[0]
    lifted = np.zeros(frequencies.size, dtype=np.complex128)
    fundamental = np.zeros(frequencies.size, dtype=np.complex128)
    held_force = frame.force_over_frame(push)
    for number, frequency in enumerate(frequencies):
        step = np.exp(1j * frequency * frame.control_period)
        frames = step**frame.samples
        resolvent = frames * np.eye(n) - frame.map
        lifted[number] = complex(np.vdot(read, solve_complex(resolvent, held_force)[:m]))
        # Force e^{jωk} at tick k: what it leaves at the end of the frame, then the loop's answer.
        left = np.zeros(n, dtype=np.complex128)
        for k in range(frame.samples):
            left[:m] = frame.tick @ left[:m] + push * step**k
        state = solve_complex(resolvent, left)
        held = frame.held_effect @ (frame.held @ state)
        inside = state[:m]
        total = 0.0 + 0.0j
        for k in range(frame.samples):
            total += complex(read @ inside) * step**-k
            inside = frame.tick @ inside + held + push * step**k
        fundamental[number] = total / frame.samples
    limit = np.pi / (frame.samples * frame.control_period)
    return Response(frequencies, lifted, fundamental, limit)


def _ideal(parameters: Parameters, timing: Timing, case: Case, frequencies: Real) -> Response:
    """Hand and object as one rigid mass, sampled like the others; the wall is continuous."""
    single = parameters.architecture == "single"
    mass = (
        parameters["m_h1"]
        + parameters["m_o" if single or parameters.architecture == "centralized" else "m_o1"]
    )
    stiffness, damping = parameters["k_w"], parameters["b_w"] + parameters["b_h1"]
    A = np.array([[0.0, 1.0], [-stiffness / mass, -damping / mass]])
    B = np.array([[0.0], [1.0 / mass]])
    read = np.array([0.0, 1.0]) if case == "free" else np.array([1.0, 0.0])

    def sampled(period: float) -> Complex:
        F, G = zero_order_hold(A, B, period)
        found = [
            complex(np.vdot(read, solve_complex(np.exp(1j * w * period) * np.eye(2) - F, G[:, 0])))
            for w in frequencies
        ]
        return np.array(found, dtype=np.complex128)

    frame = float(timing.network_period)
    return Response(
        frequencies, sampled(frame), sampled(float(timing.control_period)), np.pi / frame
    )
