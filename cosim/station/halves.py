"""Whether every station of a scenario could run its half; nothing is opened."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from cosim.base.component import Component
from cosim.base.errors import InputError, InputErrors
from cosim.link.stream.peer_link import PeerLink
from cosim.link.stream.remote import Grid, RemoteStation
from cosim.master.assembly.assemble import Assembly
from cosim.preparation.prepare import prepare
from cosim.station.half import Half
from cosim.station.split import split


def refuse_unusable_halves(assembly: Assembly) -> None:
    """Split a scenario at each of its stations, and prepare each half as its station would.

    Raises:
        InputError: what a station would refuse of its half, though the whole can be run.
    """
    scenario = assembly.scenario
    joined = {station for channel in scenario.channels.values() for station in channel.between}
    crossed = {bundle.channel for bundle in assembly.wiring.bundles}
    linked = {
        station
        for name, channel in scenario.channels.items()
        if name in crossed
        for station in channel.between
    }
    errors: list[InputError] = []
    for own in sorted(joined & linked):
        try:
            half = split(assembly, own)
            prepare(half.scenario, instances=_stand_ins(half), recorded=False).simulation.close()
        except InputError as error:
            several = error.errors if isinstance(error, InputErrors) else [error]
            errors += [InputError(f"as station {own}: {e.message}", e.location) for e in several]
    if errors:
        raise errors[0] if len(errors) == 1 else InputErrors(errors)


def _stand_ins(half: Half) -> Mapping[str, Component]:
    """Remote stations that reach nobody: they only have the variables."""
    tick = Fraction(1_000_000_000) / half.scenario.base_rate
    grid = Grid(tick_ns=float(tick))
    return {
        peer.component: RemoteStation(
            PeerLink(
                sends=peer.sends,
                receives=peer.receives,
                settings=peer.settings,
                transport=_Nowhere(),
                forward=_drop,
            ),
            grid=grid,
            now=_no_time,
        )
        for peer in half.peers
    }


class _Nowhere:
    """A transport without a network: nothing comes, and what is sent is gone."""

    def receive(self, buffer: memoryview) -> int:
        del buffer
        return -1

    def arrival(self) -> int:
        return 0

    def send(self, datagram: memoryview | bytes) -> bool:
        del datagram
        return False

    def discard(self) -> int:
        return 0

    def guard(self, session: int, floor: int, *, handshakes: bool) -> None:
        del session, floor, handshakes

    def unguard(self) -> None:
        """There is nothing to let in."""


def _drop(datagram: memoryview, at: int) -> None:
    del datagram, at


def _no_time() -> int:
    return 0
