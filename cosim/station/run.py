"""Running one workstation: its half of the scenario, its links, its sessions, its record."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import lcm
from pathlib import Path
from typing import Any, Protocol

from cosim.base.component import Component
from cosim.link.session.client import HandshakeProcess
from cosim.link.session.keys import read_key_file
from cosim.link.session.start import EXCHANGES
from cosim.link.stream.form import LONGEST_DELAY
from cosim.link.stream.peer_link import PeerLink
from cosim.link.stream.phase import PhaseFollower
from cosim.link.stream.remote import Grid, RemoteStation
from cosim.link.wire.address import Address, refuse_open_network
from cosim.link.wire.sockets import open_sockets
from cosim.link.wire.transport import UdpTransport
from cosim.master.run.execution.loop import Progress
from cosim.master.run.simulation import Simulation
from cosim.preparation.prepare import Judge, prepare
from cosim.realtime.pacing import DeadlinePacer, Policy, sleep_until
from cosim.record.folder import check_folder
from cosim.record.writer import Recorder
from cosim.run import Finished, run_scenario
from cosim.scenario import Scenario
from cosim.scenario.resolved import to_yaml
from cosim.station.admission import CompiledAdmission
from cosim.station.contract import contract_of
from cosim.station.facts import link_facts
from cosim.station.half import Half, Peer
from cosim.station.merge import FULL_SCENARIO_FILE
from cosim.station.pacing import CATCH_UP, StationPacer
from cosim.station.partners import addresses_of, key_files_of
from cosim.station.split import split

EXCHANGES_TO_CHOOSE = 100
"""Clock exchanges before the start where a delay is chosen from their percentiles: two seconds."""


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


class DelayBound(Protocol):
    """What a scenario's theory says of the delay: stable up to ``samples`` each way."""

    @property
    def samples(self) -> int:
        """Network samples; 0 where one is too many."""
        ...

    @property
    def bounded(self) -> bool:
        """Whether one more is unstable."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrangement:
    """How a station reaches the others, and how its loop keeps time."""

    listen: Address
    peers: Mapping[str, Address]
    execute: Executor
    key_files: Mapping[str, Path] = field(default_factory=dict[str, Path])
    """Of each peer; of the name "" where there is one peer."""
    policy: Policy = "count"
    patience: float | None = None
    """Seconds to wait for the others; ``None``: as long as it takes."""
    sleep: Callable[[int], None] = sleep_until
    theory: Callable[[Scenario], DelayBound | None] = lambda _: None
    """Asked where the scenario does not say how long the way may be; ``None``: it does not know."""


def run_station(
    scenario: Scenario,
    own: str,
    arrangement: Arrangement,
    *,
    say: Callable[[str], None],
    judge: Judge | None = None,
    out: Path | None = None,
    figure: bool = True,
    page: bool | None = None,
    instances: Mapping[str, Component] | None = None,
) -> Finished:
    """Run station ``own`` of a scenario in real time, linked to the others.

    ``instances`` holds components of the station that exist already, by name.

    Raises:
        InputError: the scenario, a name, an address or the key cannot be used; or a peer runs
            something else.
        RunError: the others did not come.
    """
    check_folder(out)
    with prepare(scenario, judge=judge, recorded=False).simulation as simulation:
        full = simulation.assembly
        half = split(full, own)
    names = [peer.name for peer in half.peers]
    addresses = addresses_of(own, names, arrangement.peers)
    key_files = key_files_of(own, names, arrangement.key_files)
    for address, key_file in zip(addresses, key_files, strict=True):
        refuse_open_network([arrangement.listen, address], has_key=key_file is not None)
    for key_file in dict.fromkeys(key_files):
        if key_file is not None:
            # Only to refuse a bad one now: the key itself is for the handshake process.
            read_key_file(key_file)
    _bound_delays(half, scenario, arrangement.theory, say)
    for sentence in half.dropped:
        say(f"left out at {own}: {sentence}")
    tick = 1 / scenario.base_rate
    period = lcm(*(b.period for peer in half.peers for b in (*peer.sends, *peer.receives)))
    process = HandshakeProcess(own, names)
    sockets = open_sockets(arrangement.listen, addresses)
    try:
        grid = Grid(tick_ns=float(tick * 1_000_000_000))
        transports = [UdpTransport(link) for link in sockets]
        leader = min(scenario_stations(half))
        remotes = [
            _remote(peer, transport, process, number, grid=grid, follows=peer.name == leader)
            for number, (peer, transport) in enumerate(zip(half.peers, transports, strict=True))
        ]
        process.links = [remote.link for remote in remotes]
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
            process=process,
            say=say,
            period=period,
            patience=arrangement.patience,
            idle=execute.idle,
        )

        def facts() -> dict[str, Any]:
            process.leave()
            if not process.facts:
                say(
                    "the process that shakes hands had ended, or did not answer: its counts are "
                    "missing, and a peer that was lost could not come back"
                )
            return link_facts(own, grid, half.peers, remotes, process)

        execute.facts = facts
        chooses = any(setting.delay == "auto" for peer in half.peers for setting in peer.settings)
        process.open(
            sockets=sockets,
            key_files=key_files,
            contracts=[contract_of(full, half, peer) for peer in half.peers],
            addresses=[str(address) for address in addresses],
            tick=tick,
            period=period,
            exchanges=EXCHANGES_TO_CHOOSE if chooses else EXCHANGES,
        )
        links = {p.component: remote for p, remote in zip(half.peers, remotes, strict=True)}
        finished = run_scenario(
            half.scenario,
            out,
            execute=execute,
            deadlines=execute.statistics,
            figure=figure,
            page=page,
            instances={**(instances or {}), **links},
            say=say,
            link=execute.found,
        )
        full_scenario = finished.folder / FULL_SCENARIO_FILE
        full_scenario.write_text(to_yaml(full.scenario), encoding="utf-8")
        return finished
    finally:
        process.close()
        for link in sockets:
            link.close()


def _bound_delays(
    half: Half,
    scenario: Scenario,
    theory: Callable[[Scenario], DelayBound | None],
    say: Callable[[str], None],
) -> None:
    """Where the scenario does not say how long the way may be, ask its theory."""
    open_ones = [p for p in half.peers if any(s.max_delay is None for s in p.settings)]
    if not open_ones:
        return
    found = theory(scenario)
    if found is None:
        say(
            f"the theory does not know this scenario's loop, so a way of up to {LONGEST_DELAY} "
            "samples counts; say max_delay under link: to have another bound"
        )
        return
    samples = max(1, found.samples)
    if found.samples == 0:
        say(
            "the theory calls this loop unstable with one sample of delay each way; packets that "
            "take longer do not count (max_delay: 1)"
        )
    elif found.bounded:
        say(f"the theory allows {samples} samples of delay each way: longer ways do not count")
    longest = max(s.least_delay for p in open_ones for s in p.settings if s.max_delay is None)
    if (found.bounded or found.samples == 0) and longest > samples:
        say(f"delay: {longest} is longer than that, so the theory calls this loop unstable")
    for peer in open_ones:
        peer.settings = [
            setting.model_copy(update={"max_delay": max(samples, setting.least_delay)})
            if setting.max_delay is None
            else setting
            for setting in peer.settings
        ]


def scenario_stations(half: Half) -> list[str]:
    """The stations that talk to each other, this one included."""
    return [half.own, *(peer.name for peer in half.peers)]


def _remote(
    peer: Peer,
    transport: UdpTransport,
    process: HandshakeProcess,
    number: int,
    *,
    grid: Grid,
    follows: bool,
) -> RemoteStation:
    link = PeerLink(
        sends=peer.sends,
        receives=peer.receives,
        settings=peer.settings,
        transport=transport,
        forward=process.forward(number),
        hear=process.hear,
        judge=CompiledAdmission,
    )
    return RemoteStation(
        link,
        grid=grid,
        now=time.monotonic_ns,
        follower=PhaseFollower() if follows and peer.clock == "follow" else None,
    )
