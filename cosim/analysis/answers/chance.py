"""Whether a run is stable whose packets are lost or late by chance, and how much loss it stands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from cosim.analysis.chance.chain import chain_of
from cosim.analysis.chance.delays import PacketDelays, link_delays
from cosim.analysis.chance.fate_maps import FateMaps, fate_maps, links_of
from cosim.analysis.monodromy.point import Point
from cosim.analysis.monodromy.saved_bundle import reads_ages
from cosim.base.errors import InputError
from cosim.scenario.impairments.loss import GilbertElliott
from cosim.theory.chance.packets import Losses
from cosim.theory.numerics import find_root

HIGHEST = 0.999
"""Where the search for the critical loss ends."""


@dataclass(frozen=True, slots=True)
class RunOfChance:
    """A run whose packets draw their fates.

    Attributes:
        links: what the scenario's channels do to each direction's packets.
        maps: of every fate.
        losses: whether directions lose packets each by itself or all together.
        aged: whether a part reads how old a packet is.
    """

    links: tuple[PacketDelays, ...]
    maps: FateMaps
    losses: Losses
    aged: bool

    def radius(self, loss: float | GilbertElliott | None = None) -> float:
        """The mean-square radius over a period, with the scenario's own losses or with others."""
        links = self.links if loss is None else [link.losing(loss) for link in self.links]
        return self.maps.mean_square_radius(chain_of(links, self.losses, aged=self.aged))

    def critical_loss(self) -> float | None:
        """The smallest loss, in place of the scenario's own, at which it is unstable; None: 0.999.

        What else the channels do, such as jitter, stays.
        """
        radius = cache(self.radius)
        if radius(0.0) >= 1.0 - 1e-12:
            return 0.0
        stable = 0.0
        for loss in map(float, (*np.linspace(0.1, 0.9, 9), 0.99, HIGHEST)):
            if not self._surely_decays(loss) and radius(loss) >= 1.0:
                return find_root(lambda p: math.log(radius(p)), stable, loss, 1e-6)
            stable = loss
        return None

    def _surely_decays(self, loss: float) -> bool:
        links = [link.losing(loss) for link in self.links]
        return self.maps.surely_decays(chain_of(links, self.losses, aged=self.aged))


def own_chance(point: Point) -> RunOfChance | None:
    """The run with what its own channels do; None where every packet arrives after a fixed time.

    Raises:
        InputError: they do what has no theory, by name.
    """
    if all(b.bundle.fates.is_constant for b in point.run.bundles):
        return None
    links = _links(point)
    if all(link.is_certain for link in links):
        return None
    return _run_of_chance(point, links, "independent")


def with_losses(point: Point, losses: Losses = "independent") -> RunOfChance:
    """The run with what its channels do to the packets that arrive, and any loss.

    Raises:
        InputError: nothing crosses a channel, or its channels do what has no theory.
    """
    return _run_of_chance(point, tuple(link.losing(0.5) for link in _links(point)), losses)


def _links(point: Point) -> tuple[PacketDelays, ...]:
    scenario = point.run.simulation.scenario
    return tuple(link_delays(scenario, link) for link in links_of(point))


def _run_of_chance(point: Point, links: tuple[PacketDelays, ...], losses: Losses) -> RunOfChance:
    aged = reads_ages(point.run.simulation)
    if aged and any(link.loss for link in links):
        raise InputError(
            "Packets are lost, and a part reads how old the last one is, to predict from it: that "
            "grows without end. Ask without prediction (predictor=hold_last), or without loss.",
        )
    maps = fate_maps(point, chain_of(links, losses, aged=aged))
    return RunOfChance(links, maps, losses, aged)
