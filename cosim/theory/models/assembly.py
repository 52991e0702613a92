"""The stations and links of a cooperative loop, read from its model (figures 4.3 and 4.4)."""

from __future__ import annotations

import numpy as np

from cosim.theory.models.frame import FrameAssembly, Link
from cosim.theory.models.mass_spring_damper import Centralized, Model
from cosim.theory.models.station import Station, hand_alone, object_station
from cosim.theory.models.timing import Timing


def assemble(model: Model, timing: Timing) -> FrameAssembly:
    """The stations and links of a model.

    Raises:
        InputError: where T_t is not a multiple of T_c.
    """
    samples = timing.samples_per_frame
    period = float(timing.control_period)
    if isinstance(model, Centralized):
        stations, links = _centralized(model, timing, period)
    else:
        stations, links = _distributed(model, timing, period)
    return FrameAssembly(tuple(stations), tuple(links), model.users, samples, period)


def _hand(model: Model, user: int) -> tuple[float, float, float]:
    """A hand's mass, damping and stiffness."""
    return float(model.hand_mass[user]), float(model.hand_damping[user]), model.hand_stiffness


def _delay(timing: Timing, source: int, target: int) -> int:
    return timing.delay.forward if source < target else timing.delay.backward


def _distributed(model: Model, timing: Timing, period: float) -> tuple[list[Station], list[Link]]:
    assert not isinstance(model, Centralized)
    users = range(model.users)
    stations: list[Station] = []
    links: list[Link] = []
    for m in users:
        stiffness = damping = 0.0
        for r in users:
            if r == m:
                continue
            felt = 1.0 if model.present[r] else 0.0
            stiffness += felt * model.remote_stiffness[m, r] + model.object_stiffness[m, r]
            damping += felt * model.remote_damping[m, r] + model.object_damping[m, r]
        held = [(stiffness, damping)]
        if model.wall_stiffness or model.wall_damping:
            held.append((model.wall_stiffness, model.wall_damping))
        stations.append(
            object_station(
                hand=_hand(model, m) if model.present[m] else None,
                local=(model.local_stiffness[m], model.local_damping[m]),
                object_mass=model.object_mass[m],
                compensation=model.compensation[m],
                held=held,
                period=period,
                computation_delay=timing.computation_delay,
            )
        )
    for m in users:
        for r in users:
            if r == m:
                continue
            source = stations[r]
            row = np.zeros(source.A.shape[-1])
            assert source.body is not None
            row[source.body] = model.object_stiffness[m, r]
            row[source.body + 1] = model.object_damping[m, r]
            if source.hand is not None:
                row[source.hand] = model.remote_stiffness[m, r]
                row[source.hand + 1] = model.remote_damping[m, r]
            links.append(Link(r, m, row, None, 0, _delay(timing, r, m)))
    return stations, links


def _centralized(
    model: Centralized, timing: Timing, period: float
) -> tuple[list[Station], list[Link]]:
    remote = [m for m in range(1, model.users) if model.present[m]]
    held = [(model.stiffness[m], model.damping[m]) for m in remote]
    if model.wall_stiffness or model.wall_damping:
        held.append((model.wall_stiffness, model.wall_damping))
    stations = [
        object_station(
            hand=_hand(model, 0) if model.present[0] else None,
            local=(model.stiffness[0], model.damping[0]),
            object_mass=model.object_mass,
            compensation=model.compensation,
            held=held,
            period=period,
            computation_delay=timing.computation_delay,
        )
    ]
    links: list[Link] = []
    for number, m in enumerate(remote):
        stations.append(hand_alone(*_hand(model, m), period=period))
        up = np.array([model.stiffness[m], model.damping[m]])
        down = stations[0].C[number]
        links.append(Link(number + 1, 0, up, None, number, timing.delay.forward))
        links.append(Link(0, number + 1, down, number, 0, timing.delay.backward))
    return stations, links
