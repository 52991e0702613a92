"""The one-frame map by subsystem resampling (4.2.1), for any number of users, with packet events.

Each workstation's loop is closed at T_c and resampled to T_t by (4.4); what the network carries is
one number per link (the force share K X̄ of what was sent, or the force itself on the way down),
because all of a packet's values are held together. A link keeps the samples still under way and,
where packets can be lost, the one that is held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cosim.theory.models.station import Station
from cosim.theory.numerics import Real, solve

HOLD = -1
"""A link event: nothing arrives, the value held so far stays. Other events are the age in samples
of the packet that is held from this frame on."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One network period T_t of a cooperative loop: s⁺ = M s, with forces entering at the ticks.

    The state s is (states of the stations at the frame's start; per link the samples sent before,
    newest first, and the held value where there is one).

    Attributes:
        map: M, shape (n, n).
        tick: the stations' state matrix over one tick, shape (m, m).
        held: what the links hold during the frame as rows over s, shape (links, n).
        held_effect: effect of the held values over one tick, shape (m, links).
        force_on_hand: shape (users, m), effect of 1 N on each hand over one tick.
        force_on_object: shape (objects, m), effect of 1 N on each object copy over one tick.
        hand: index of each hand's position in s, None where there is no hand.
        body: index of each object copy's position in s.
        translation: s after everything moved by 1 m, shape (n,).
        samples: N, ticks per frame.
        control_period: T_c in s.
    """

    map: Real
    tick: Real
    held: Real
    held_effect: Real
    force_on_hand: Real
    force_on_object: Real
    hand: tuple[int | None, ...]
    body: tuple[int, ...]
    translation: Real
    samples: int
    control_period: float

    def force_over_frame(self, effect: Real) -> Real:
        """The effect on s of a force that is held over the whole frame.

        Args:
            effect: its effect over one tick, shape (m,).

        Returns:
            Shape (n,): (A^{N−1} + … + I) effect, and zero on the links' memory.
        """
        column = np.zeros(self.map.shape[0])
        total = np.zeros_like(effect)
        for _ in range(self.samples):
            total = self.tick @ total + effect
        column[: total.size] = total
        return column


@dataclass(frozen=True, slots=True)
class Link:
    """A directed link: what it samples, what it drives, and how late.

    Attributes:
        source: station that sends.
        target: station that receives.
        row: what is sent as a row over the source's state, shape (n_source,).
        through: index of the source's held coupler whose reaction is sent, or None.
        input: index of the target's input that the value drives.
        delay: in network samples.
    """

    source: int
    target: int
    row: Real
    through: int | None
    input: int
    delay: int


@dataclass(frozen=True, slots=True)
class FrameAssembly:
    """Stations and links of a cooperative loop, before the network's events are chosen."""

    stations: tuple[Station, ...]
    links: tuple[Link, ...]
    users: int
    samples: int
    control_period: float

    def frame(
        self, events: Sequence[int] | None = None, depth: Sequence[int] | None = None
    ) -> Frame:
        """The one-frame map under the given packet events.

        Args:
            events: per link the age in samples of the packet that is held from this frame on, or
                `HOLD`. None: every packet arrives after the link's own delay.
            depth: per link how many past samples the state keeps; a link listed here also keeps
                the held value. None: only what the fixed delays need.
        """
        return _assemble(self, events, depth)


def _assemble(
    assembly: FrameAssembly, events: Sequence[int] | None, depth: Sequence[int] | None
) -> Frame:
    stations, links = assembly.stations, assembly.links
    offsets = np.concatenate([[0], np.cumsum([station.A.shape[-1] for station in stations])])
    offset = [int(value) for value in offsets]
    m = offset[-1]
    keeps_held = depth is not None
    depths = [link.delay for link in links] if depth is None else list(depth)
    chosen = [link.delay for link in links] if events is None else list(events)
    memory: list[int] = []
    n = m
    for kept in depths:
        memory.append(n)
        n += kept + (1 if keeps_held else 0)

    tick = np.zeros((m, m))
    held_effect = np.zeros((m, len(links)))
    for number, station in enumerate(stations):
        tick[offset[number] : offset[number + 1], offset[number] : offset[number + 1]] = station.A
    # What each link samples at the frame's start: sent = rows s + feed held.
    rows = np.zeros((len(links), n))
    feed = np.zeros((len(links), len(links)))
    translation = np.zeros(n)
    for number, station in enumerate(stations):
        translation[offset[number] : offset[number + 1]] = station.translation
    for number, link in enumerate(links):
        source = slice(offset[link.source], offset[link.source + 1])
        target = slice(offset[link.target], offset[link.target + 1])
        rows[number, source] = link.row
        held_effect[target, number] += stations[link.target].B[:, link.input]
        if link.through is not None:
            for other, driver in enumerate(links):
                if driver.target == link.source:
                    feed[number, other] = stations[link.source].D[link.through, driver.input]
    # held = fresh (rows s + feed held) + stored s, and fresh · feed is nilpotent: no loop.
    fresh = np.zeros((len(links), len(links)))
    stored = np.zeros((len(links), n))
    for number, event in enumerate(chosen):
        if event == 0:
            fresh[number, number] = 1.0
        elif event == HOLD:
            stored[number, memory[number] + depths[number]] = 1.0
        else:
            stored[number, memory[number] + event - 1] = 1.0
    held = solve(np.eye(len(links)) - fresh @ feed, fresh @ rows + stored)

    frame_map = np.zeros((n, n))
    power, total = np.eye(m), np.zeros((m, m))
    for _ in range(assembly.samples):
        total = total + power
        power = tick @ power
    frame_map[:m, :m] = power
    frame_map[:m] += total @ held_effect @ held
    sent = rows + feed @ held
    for number, kept in enumerate(depths):
        first = memory[number]
        for place in range(kept):
            frame_map[first + place] = sent[number] if place == 0 else _unit(n, first + place - 1)
        if keeps_held:
            frame_map[first + kept] = held[number]

    # Everything moved by 1 m: what is sent follows from the stations, link by link.
    moved = solve(np.eye(len(links)) - feed, rows @ translation)
    for number, kept in enumerate(depths):
        translation[memory[number] : memory[number] + kept + (1 if keeps_held else 0)] = moved[
            number
        ]
    hands, bodies, push_hand, push_object = _ports(assembly, offset)
    return Frame(
        map=frame_map,
        tick=tick,
        held=held,
        held_effect=held_effect,
        force_on_hand=push_hand,
        force_on_object=push_object,
        hand=hands,
        body=bodies,
        translation=translation,
        samples=assembly.samples,
        control_period=assembly.control_period,
    )


def _ports(
    assembly: FrameAssembly, offset: list[int]
) -> tuple[tuple[int | None, ...], tuple[int, ...], Real, Real]:
    """Where the hands and objects are in the state, and what a force on them does."""
    hands: list[int | None] = []
    bodies: list[int] = []
    on_hand: list[Real] = []
    on_object: list[Real] = []
    for number, station in enumerate(assembly.stations):
        place = slice(offset[number], offset[number + 1])
        for start, effect, kind in (
            (station.hand, station.force_on_hand, "hand"),
            (station.body, station.force_on_object, "body"),
        ):
            column = np.zeros(offset[-1])
            column[place] = effect
            if kind == "hand":
                hands.append(None if start is None else offset[number] + start)
                on_hand.append(column)
            elif start is not None:
                bodies.append(offset[number] + start)
                on_object.append(column)
    return tuple(hands), tuple(bodies), np.array(on_hand), np.array(on_object)


def _unit(size: int, index: int) -> Real:
    row = np.zeros(size)
    row[index] = 1.0
    return row
