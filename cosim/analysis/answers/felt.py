"""What a user feels in a run: admittance over frequency, and damping where all moves freely."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.answers.asked import AskedRun
from cosim.analysis.answers.push import Push, held_push, push_response
from cosim.analysis.monodromy.blocks import connected_blocks, dropped
from cosim.analysis.monodromy.point import Point
from cosim.base.errors import InputError
from cosim.theory.numerics import solve_complex
from cosim.theory.transparency.admittance import Case
from cosim.theory.transparency.compensation import nulling
from cosim.theory.transparency.steady import steady_drift

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class FeltResponse:
    """Velocity (or position) over force by both definitions, shape (f,) each."""

    frame_lifted: Complex
    fundamental: Complex


def felt_response(point: Point, push: Push, case: Case, frequencies: Real) -> FeltResponse:
    """What a hand's velocity (free) or position (contact) makes of a force on it.

    Args:
        point: the run.
        push: whose hand.
        case: what is read.
        frequencies: rad/s, shape (f,).
    """
    run = point.run
    scenario = run.simulation.scenario
    tick = float(1 / scenario.base_rate)
    highest = np.pi / tick
    if np.any(frequencies <= 0) or np.any(frequencies > highest):
        raise InputError(
            f"Frequencies must be above 0 and below half the base rate, {highest:.6g} rad/s."
        )
    found = push_response(run, push, push.velocity if case == "free" else push.position)
    kept = ~dropped([point.matrix])
    matrix = point.matrix[np.ix_(kept, kept)]
    force, read = found.force[kept], found.read[:, kept]
    size = run.steps[kept]
    matrix = matrix * size[None, :] / size[:, None]
    force, read = force / size[:, None], read * size[None, :]
    ticks = np.arange(run.hyperperiod)
    lifted = np.zeros(frequencies.size, dtype=np.complex128)
    fundamental = np.zeros(frequencies.size, dtype=np.complex128)
    for number, frequency in enumerate(frequencies):
        turn = np.exp(1j * frequency * tick * ticks)
        z = np.exp(1j * frequency * tick * run.hyperperiod)
        resolvent = z * np.eye(matrix.shape[0]) - matrix
        lifted[number] = read[0] @ solve_complex(resolvent, force.sum(axis=1))
        state = solve_complex(resolvent, force @ turn)
        seen = read @ state + found.direct @ turn
        fundamental[number] = np.mean(seen * np.conj(turn))
    return FeltResponse(lifted, fundamental)


def run_damping(point: Point, push: Push) -> float:
    """The DC damping lim F/V (N·s/m) of a hand that moves freely, the force held throughout.

    Raises:
        InputError: a wall, a hand's own spring or a mechanism holds it.
    """
    run = point.run
    if not run.is_linear:
        raise InputError(
            "The damping is a property of free motion, and a hand on a device holds its place: ask "
            "for the admittance, or for the loop of chapter 6 with --architecture."
        )
    kept = ~dropped([point.matrix])
    blocks = connected_blocks([point.matrix], kept)
    force = held_push(run, [push])
    place = next(
        number
        for number, one in enumerate(run.coordinates)
        if one.owner == push.hand and one.name == "velocity"
    )
    reached = next(block for block in blocks if place in block)
    shift = np.array([1.0 if run.coordinates[n].unit == "m" else 0.0 for n in map(int, reached)])
    inner = point.matrix[np.ix_(reached, reached)]
    if not np.allclose(inner @ shift, shift, rtol=0.0, atol=1e-9):
        raise InputError(
            "The damping is a property of free motion: take the wall away, or ask for the "
            "stiffness."
        )
    seconds = float(point.seconds)
    needed, drift = steady_drift(inner, force[reached], shift, seconds)
    return needed / float(drift[int(np.flatnonzero(reached == place)[0])])


@dataclass(frozen=True, slots=True)
class RunCompensation:
    """The damping as it is (N·s/m), the b_c of every copy that nulls it; radius, verdict then."""

    damping: float
    value: float
    radius: float
    verdict: str
    marginal: bool


def null_run_damping(asked: AskedRun, push: Push) -> RunCompensation:
    """b_c, the same on every copy of the object, at which the damping of the run vanishes.

    Raises:
        InputError: the scenario has no object to compensate, or none up to 1000 N·s/m is enough.
    """
    present = run_damping(asked.point(), push)
    if "b_c" not in asked.names and "b_c1" not in asked.names:
        raise InputError("The scenario has no object whose compensation could null the damping.")

    def damping(value: float) -> float:
        sets = asked.sets("b_c", value)
        found = run_damping(asked.point(sets), push)
        asked.forget(sets)
        return found

    value = nulling(damping)
    spectrum = asked.point(asked.sets("b_c", value)).spectrum()
    return RunCompensation(present, value, spectrum.radius, spectrum.verdict, spectrum.marginal)
