"""The theory of one scenario at one moment: its map, operating point and spectrum."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.monodromy.idealised import damped
from cosim.analysis.monodromy.jacobian import jacobian
from cosim.analysis.monodromy.operating_point import (
    Newton,
    Settled,
    moving_on_the_way,
    refuse_moving,
    settle,
)
from cosim.analysis.monodromy.refusal import refuse_what_has_no_theory
from cosim.analysis.monodromy.run_map import RunMap
from cosim.analysis.monodromy.spares import Spares
from cosim.analysis.monodromy.spectrum import RunSpectrum, spectrum
from cosim.base.errors import InputError, RunError
from cosim.master.run.simulation import Simulation
from cosim.scenario import Scenario
from cosim.scenario.load import Written

Real = NDArray[np.float64]

LOOKS = 16
"""Moments a second at which a run is asked whether it rests, where none is given."""


@dataclass(slots=True)
class Point:
    """A run at its operating point; close it when done.

    Attributes:
        run: the map, standing there.
        settled: what is known of its derivative.
        tick: of the operating point.
    """

    run: RunMap
    settled: Settled
    tick: int

    @property
    def matrix(self) -> Real:
        """dΦ/dx, shape (n, n), over one hyperperiod.

        Raises:
            InputError: there is no derivative here.
        """
        if self.settled.matrix is None:
            found = jacobian(self.run)
            newton = None if self.run.is_linear else Newton(self.run, found)
            self.settled = Settled(found, newton)
        assert self.settled.matrix is not None
        return self.settled.matrix

    @property
    def seconds(self) -> Fraction:
        """One hyperperiod (s)."""
        return Fraction(self.run.hyperperiod) / self.run.simulation.scenario.base_rate

    @property
    def period(self) -> Fraction:
        """The network period, the control period where nothing is sent, or the hyperperiod (s)."""
        scenario = self.run.simulation.scenario
        used = {link.via for link in scenario.connections if link.via is not None}
        periods = {scenario.channels[name].period for name in used}
        if not periods:
            periods = {scenario.components[name].period for name in self.run.fmus}
        if len(periods) != 1:
            return self.seconds
        return Fraction(periods.pop()) / scenario.base_rate

    def spectrum(self, *, with_modes: bool = False) -> RunSpectrum:
        """The eigenvalues that decide."""
        return spectrum(
            self.matrix,
            self.run.coordinates,
            seconds=self.seconds,
            period=self.period,
            is_linear=self.run.is_linear,
            with_modes=with_modes,
        )

    def close(self) -> None:
        """Free the run."""
        self.run.simulation.close()

    def __enter__(self) -> Point:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def find_point(
    written: Written,
    at: Fraction | None = None,
    near: Point | None = None,
    spares: Spares | None = None,
) -> Point:
    """Run a scenario up to a moment and find its operating point there.

    Args:
        written: what runs; of what its channels do by chance every packet has the longest delay,
            so that all that may still arrive is in flight.
        at: the moment (s); None: for what is linear any, else the last one at which nothing moves.
        near: the operating point of a run that differs in parameters alone, which may be closed;
            the search begins there, and nothing is run. Of no account where the plan differs too.
        spares: where the simulation comes from; a new one unless given.

    Raises:
        InputError: a part has no derivative or does not declare its state, or nothing rests.
    """
    scenario = written.built()
    refuse_what_has_no_theory(scenario)
    from_where = spares or Spares()
    if near is not None:
        point = _settled(scenario, from_where, near.run, near.settled.newton)
        if point is not None:
            return point
    with ExitStack() as until_known:
        run = _stand(until_known.enter_context(from_where.started(scenario)), at)
        if run is not None and run.is_linear:
            point = _known(Point(run, settle(run), run.tick))
            until_known.pop_all()
            return point
    if at is None:
        at = _last_rest(damped(written, scenario).built())
    problems: list[InputError] = []
    for candidate in (scenario, damped(written, scenario).built()):
        with Spares().started(candidate) as simulation:
            try:
                run = _stand(simulation, at)
                assert run is not None
                refuse_moving(run)
                found = _settled(scenario, from_where, run)
                assert found is not None, "damping is a parameter"
                return _known(found)
            except InputError as problem:
                problems.append(problem)
    raise problems[-1]


def _known(point: Point) -> Point:
    """The same with its derivative, which shows whether there is one.

    Raises:
        InputError: there is none.
    """
    try:
        _ = point.matrix
    except BaseException:
        point.close()
        raise
    return point


def _settled(
    scenario: Scenario, spares: Spares, near: RunMap, nearby: Newton | None = None
) -> Point | None:
    """A run of its own at its operating point near where another stands; None: of another plan."""
    simulation = spares.started(scenario)
    try:
        run = RunMap(simulation)
        if not run.has_plan_of(near):
            simulation.close()
            return None
        run.adopt(near)
        return Point(run, settle(run, nearby), run.tick)
    except BaseException:
        simulation.close()
        raise


def _stand(simulation: Simulation, at: Fraction | None) -> RunMap | None:
    """The map at a moment; without one, at the first where all channels are full, if linear."""
    period = int(simulation.program.kernel.hyperperiod)
    earliest = _filled(simulation)
    first = -(-earliest // period) * period
    if at is None:
        simulation.advance(first)
        run = RunMap(simulation)
        return run if run.is_linear else None
    scenario = simulation.scenario
    wanted = int((at - scenario.start_time) * scenario.base_rate) // period * period
    if wanted < first:
        seconds = float(scenario.start_time + first / scenario.base_rate)
        raise InputError(
            f"--at {float(at):g} s is too early: the channels are not full before {seconds:g} s."
        )
    if wanted > simulation.scenario.ticks:
        raise InputError(
            f"--at {float(at):g} s is beyond the scenario's "
            f"{float(scenario.start_time + scenario.duration):g} s."
        )
    _advance(simulation, wanted)
    return RunMap(simulation)


def _filled(simulation: Simulation) -> int:
    """The tick from which on as much is in flight as ever will be, and velocities are known."""
    bundles = simulation.assembly.wiring.bundles
    longest = max((bundle.fates.longest + bundle.period for bundle in bundles), default=0)
    return longest + 33


def _last_rest(scenario: Scenario) -> Fraction:
    """The last moment (s) at which no signal and no operator moves.

    Raises:
        InputError: there is none.
    """
    with Spares().started(scenario) as simulation:
        period = int(simulation.program.kernel.hyperperiod)
        looked = max(period, int(scenario.base_rate / LOOKS) // period * period)
        first = -(-_filled(simulation) // looked) * looked
        last: int | None = None
        moving: str | None = ""
        try:
            simulation.advance(first)
            run = RunMap(simulation)
            for tick in range(first, scenario.ticks + 1, looked):
                simulation.advance(tick)
                moving = moving_on_the_way(run)
                if moving is None:
                    last = tick
        except RunError:
            if last is None:
                raise
        if last is None:
            raise InputError(
                f"{moving} moves all the time, and a run has an operating point only where what "
                "users want stands still. Let it rest, or measure the run instead."
            )
        return scenario.start_time + Fraction(last) / scenario.base_rate


def _advance(simulation: Simulation, tick: int) -> None:
    try:
        simulation.advance(tick)
    except RunError as error:
        raise InputError(
            f"The run does not come to tick {tick}: {error} Choose an earlier moment with --at."
        ) from None
