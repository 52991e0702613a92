"""Running one workstation: its half of the scenario, its links, its door, its record."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import lcm
from pathlib import Path
from typing import Any, Protocol

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.link.session.door import Door
from cosim.link.session.keys import read_key_file
from cosim.link.stream.clock import PhaseFollower
from cosim.link.stream.peer_link import PeerLink
from cosim.link.stream.receiver import Fate
from cosim.link.stream.remote import Grid, RemoteStation
from cosim.link.stream.settings import ClockMode
from cosim.link.wire.transport import Address, UdpTransport, open_socket, refuse_open_network
from cosim.master.assembly.assemble import put_together
from cosim.master.run.pacing import DeadlinePacer, Policy, sleep_until
from cosim.master.run.simulation import Progress, Simulation
from cosim.record.playback import KINDS
from cosim.record.writer import Recorder
from cosim.scenario import Scenario
from cosim.scenario.resolved import to_yaml
from cosim.session import Finished, run_scenario
from cosim.station.contract import contract_of
from cosim.station.merge import FULL_SCENARIO_FILE
from cosim.station.pacing import CATCH_UP, StationPacer
from cosim.station.split import Half, Peer, split


class Executor(Protocol):
    """Runs the loop in a process of its own, records in this one, and tells how it went."""

    pacer: Any
    facts: Callable[[], Mapping[str, Any]] | None
    """Asked in the loop's process after the loop."""

    def __call__(
        self, simulation: Simulation, recorder: Recorder, progress: Progress | None
    ) -> None:
        """Run to the scenario's end."""
        ...

    def statistics(self) -> Mapping[str, Any]:
        """Deadlines and what the system granted."""
        ...

    def found(self) -> Mapping[str, Any]:
        """What ``facts`` said; empty where the loop never came to its end."""
        ...

    def idle(self) -> bool:
        """Keep the devices at zero while waiting; whether there are any."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrangement:
    """How a station reaches the others, and how its loop keeps time."""

    listen: Address
    peers: Mapping[str, Address]
    execute: Executor
    key_file: Path | None = None
    policy: Policy = "count"
    patience: float | None = None
    """Seconds to wait for the others; ``None``: as long as it takes."""
    sleep: Callable[[int], None] = sleep_until


def run_station(
    scenario: Scenario,
    own: str,
    arrangement: Arrangement,
    *,
    say: Callable[[str], None],
    out: Path | None = None,
    figure: bool = True,
) -> Finished:
    """Run station ``own`` of a scenario in real time, linked to the others.

    Raises:
        InputError: the scenario, a name, an address or the key cannot be used; or a peer runs
            something else.
        RunError: the others did not come.
    """
    full = put_together(scenario, kinds=KINDS)
    half = split(full, own)
    addresses = _addresses(half, arrangement.peers)
    refuse_open_network([arrangement.listen, *addresses], has_key=arrangement.key_file is not None)
    if arrangement.key_file is not None:
        # Only to refuse a bad one now: the key itself is for the process at the door.
        read_key_file(arrangement.key_file)
    for sentence in half.dropped:
        say(f"left out at {own}: {sentence}")
    tick = 1 / scenario.base_rate
    period = lcm(*(b.period for peer in half.peers for b in (*peer.sends, *peer.receives)))
    shared = len(addresses) > 1
    door = Door(own, [peer.name for peer in half.peers])
    sockets = [open_socket(arrangement.listen, address, shared=shared) for address in addresses]
    try:
        grid = Grid(tick_ns=float(tick * 1_000_000_000))
        transports = [UdpTransport(link) for link in sockets]
        leader = min(scenario_stations(half))
        remotes = [
            _remote(peer, transport, door.forward(number), grid, follows=peer.name == leader)
            for number, (peer, transport) in enumerate(zip(half.peers, transports, strict=True))
        ]
        door.links = [remote.link for remote in remotes]
        execute = arrangement.execute
        execute.pacer = StationPacer(
            pace=DeadlinePacer(
                tick_seconds=tick,
                policy=arrangement.policy,
                catch_up=CATCH_UP,
                sleep=arrangement.sleep,
            ),
            grid=grid,
            remotes=remotes,
            door=door,
            say=say,
            period=period,
            patience=arrangement.patience,
            idle=execute.idle,
        )

        def facts() -> dict[str, Any]:
            door.leave()
            return _facts(own, grid, half.peers, remotes, door)

        execute.facts = facts
        door.open(
            sockets=sockets,
            key_file=arrangement.key_file,
            contracts=[contract_of(full, half, peer) for peer in half.peers],
            tick=tick,
            period=period,
        )
        instances = {p.component: remote for p, remote in zip(half.peers, remotes, strict=True)}
        finished = run_scenario(
            half.scenario,
            out,
            execute=execute,
            deadlines=execute.statistics,
            figure=figure,
            instances=instances,
            link=execute.found,
        )
        full_scenario = finished.folder / FULL_SCENARIO_FILE
        full_scenario.write_text(to_yaml(scenario), encoding="utf-8")
        return finished
    finally:
        door.close()
        for link in sockets:
            link.close()


def scenario_stations(half: Half) -> list[str]:
    """The stations that talk to each other, this one included."""
    return [half.own, *(peer.name for peer in half.peers)]


def _addresses(half: Half, given: Mapping[str, Address]) -> list[Address]:
    """The address of every peer; one peer needs no name."""
    names = [peer.name for peer in half.peers]
    if set(given) == {""} and len(names) == 1:
        return [given[""]]
    for name in given:
        if name not in names:
            what = f"'{name}' is no peer of {half.own}" if name else "--peer needs a station's name"
            raise InputError(f"{what}.{did_you_mean(name, names)}")
    missing = [name for name in names if name not in given]
    if missing:
        raise InputError(
            f"{half.own} exchanges values with {', '.join(names)}; give the address of "
            f"{missing[0]} with --peer {missing[0]}=host:port"
        )
    return [given[name] for name in names]


def _remote(
    peer: Peer,
    transport: UdpTransport,
    forward: Callable[[memoryview, int], None],
    grid: Grid,
    *,
    follows: bool,
) -> RemoteStation:
    link = PeerLink(
        sends=peer.sends,
        receives=peer.receives,
        settings=peer.settings,
        transport=transport,
        forward=forward,
    )
    free = any(setting.clock is ClockMode.FREE for setting in peer.settings)
    return RemoteStation(
        link,
        grid=grid,
        now=time.monotonic_ns,
        leads=not follows,
        follower=PhaseFollower() if follows and not free else None,
    )


def _facts(
    own: str,
    grid: Grid,
    peers: Sequence[Peer],
    remotes: Sequence[RemoteStation],
    door: Door,
) -> dict[str, Any]:
    """What goes into the manifest; never a key."""
    found: dict[str, Any] = {
        "station": own,
        "first_tick": grid.first_tick,
        "epoch": grid.epoch,
        "sessions": door.sessions,
        "peers": {},
    }
    for peer, remote in zip(peers, remotes, strict=True):
        link, clock = remote.link, remote.link.clock
        transport = link.transport
        found["peers"][peer.name] = {
            "component": peer.component,
            "sent": link.sent,
            "refused": getattr(transport, "refused", 0),
            "unsent": getattr(transport, "unsent", 0),
            "foreign": link.foreign,
            "flood": link.flood,
            "dropped_by_kernel": getattr(transport, "dropped_by_kernel", 0),
            "clock_offset": clock.offset(time.monotonic_ns()) if clock.ready else None,
            "clock_skew": clock.skew if clock.ready else None,
            "round_trip": clock.round_trip if clock.ready else None,
            "streams": {
                item.receiver.bundle.channel: {
                    **{fate.name.lower(): int(item.receiver.counts[fate]) for fate in Fate},
                    "overdue": item.receiver.overdue,
                    "overdue_by_network": item.overdue_by_network,
                    "losses": item.weight.losses,
                }
                for item in link.incoming
            },
        }
    return found
