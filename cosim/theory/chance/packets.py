"""What a network does to packets, as Markov chains over the links of a loop.

A pattern says, per frame, with what probability each link holds a packet of which age. Losses are
drawn per packet and direction, or together for both directions; a burst is a two-state chain
(Gilbert–Elliott); a random delay is a chain over the age of the newest packet that has arrived.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.models.frame import HOLD
from cosim.theory.numerics import Real

Losses = Literal["independent", "together"]


@dataclass(frozen=True, slots=True)
class LinkProcess:
    """How one link (or all of them together) behaves from frame to frame.

    Attributes:
        transition: shape (modes, modes), row i the probabilities of what follows mode i.
        emission: shape (modes, events), the probabilities of the events in each mode.
        events: the age in samples of the packet that is held from this frame on, or HOLD.
    """

    transition: Real
    emission: Real
    events: tuple[int, ...]


def check_probability(name: str, value: float) -> None:
    """Refuse what is not a probability.

    Raises:
        InputError: outside 0..1.
    """
    if not 0.0 <= value <= 1.0:
        raise InputError(f"The {name} is {value:g}: a probability is between 0 and 1.")


def bernoulli(loss: float, delay: int) -> LinkProcess:
    """Every packet is lost with the same probability, whatever happened before."""
    check_probability("loss", loss)
    return LinkProcess(np.ones((1, 1)), np.array([[1.0 - loss, loss]]), (delay, HOLD))


def gilbert_elliott(
    good_to_bad: float,
    bad_to_good: float,
    delay: int,
    loss_good: float = 0.0,
    loss_bad: float = 1.0,
) -> LinkProcess:
    """Losses in bursts: a good and a bad state, each with its own loss probability.

    Args:
        good_to_bad: probability per packet of turning bad.
        bad_to_good: probability per packet of recovering; the mean burst is its inverse.
        delay: in network samples.
        loss_good: loss in the good state.
        loss_bad: loss in the bad state.
    """
    for name, value in (
        ("good-to-bad probability", good_to_bad),
        ("bad-to-good probability", bad_to_good),
        ("loss in the good state", loss_good),
        ("loss in the bad state", loss_bad),
    ):
        check_probability(name, value)
    transition = np.array([[1 - good_to_bad, good_to_bad], [bad_to_good, 1 - bad_to_good]])
    emission = np.array([[1 - loss_good, loss_good], [1 - loss_bad, loss_bad]])
    return LinkProcess(transition, emission, (delay, HOLD))


def random_delay(probabilities: Sequence[float], loss: float = 0.0) -> LinkProcess:
    """Each packet is late by its own number of samples; the freshest that arrived is held.

    Packets may overtake each other, and one older than what is held is dropped. The age a of what
    is held is then a Markov chain: packet k + 1 − b, b ≤ a, had not arrived before, and arrives now
    with probability P(d = b | d ≥ b) unless a newer one does; else the age becomes a + 1. Beyond
    the longest delay nothing that is still missing can arrive, and the chain ends in "older".

    Args:
        probabilities: of a delay of 0, 1, 2 … samples; they are normalised to sum to 1.
        loss: probability that a packet never arrives.

    Raises:
        InputError: for negative probabilities, or none at all.
    """
    check_probability("loss", loss)
    spread = np.asarray(probabilities, dtype=np.float64)
    if spread.size == 0 or np.any(spread < 0) or not spread.sum() > 0:
        raise InputError("The delay's probabilities must not be negative, nor all zero.")
    delays = (1.0 - loss) * spread / spread.sum()
    deepest = delays.size - 1
    # Arrival at age b, given that it has not arrived before: P(d = b) / P(d ≥ b).
    remaining = 1.0 - np.concatenate([[0.0], np.cumsum(delays)[:-1]])
    hazard = np.where(remaining > 1e-15, delays / np.where(remaining > 1e-15, remaining, 1.0), 0.0)
    modes = deepest + 2
    transition = np.zeros((modes, modes))
    for age in range(modes):
        missing = 1.0
        for arrival in range(min(age, deepest) + 1):
            transition[age, arrival] = missing * hazard[arrival]
            missing *= 1.0 - hazard[arrival]
        transition[age, min(age + 1, modes - 1)] += missing
    # Nothing is ever younger than the shortest delay.
    youngest = int(np.argmax(spread > 0))
    return LinkProcess(
        transition[youngest:, youngest:],
        np.eye(modes - youngest),
        (*range(youngest, deepest + 1), HOLD),
    )


def independent_frames(process: LinkProcess) -> LinkProcess:
    """The same long-run probabilities of events, drawn anew every frame: bursts forgotten."""
    modes = process.transition.shape[0]
    balance = np.vstack([process.transition.T - np.eye(modes), np.ones(modes)])
    share = np.linalg.lstsq(balance, np.append(np.zeros(modes), 1.0), rcond=None)[0]
    emission = np.clip(share @ process.emission, 0.0, 1.0)
    return LinkProcess(np.ones((1, 1)), (emission / emission.sum())[None, :], process.events)


@dataclass(frozen=True, slots=True)
class Pattern:
    """The joint behaviour of all links: a chain, and in each mode the probabilities of events.

    Attributes:
        transition: shape (modes, modes).
        emission: shape (modes, outcomes).
        outcomes: per outcome the event of every link.
        depth: per link how many past samples the events reach back to.
    """

    transition: Real
    emission: Real
    outcomes: tuple[tuple[int, ...], ...]
    depth: tuple[int, ...]


def join(processes: Sequence[LinkProcess], losses: Losses = "independent") -> Pattern:
    """Put the links' processes side by side.

    Args:
        processes: one per link.
        losses: ``independent``: every link has its own chain. ``together``: one chain drives all
            links, event by event; the processes may then differ in their delays only.

    Raises:
        InputError: where independent chains make more than 4096 modes.
    """
    depth = tuple(max(0, *process.events) for process in processes)
    if losses == "together":
        first = processes[0]
        outcomes = tuple(zip(*(process.events for process in processes), strict=True))
        return Pattern(first.transition, first.emission, outcomes, depth)
    modes = int(np.prod([process.transition.shape[0] for process in processes]))
    outcomes_count = int(np.prod([len(process.events) for process in processes]))
    if modes > 4096 or outcomes_count > 4096:
        raise InputError(
            f"{len(processes)} links with independent losses make {modes} modes and "
            f"{outcomes_count} outcomes: use fewer users, fewer delays, or --losses together."
        )
    transition: Real = np.ones((1, 1))
    emission: Real = np.ones((1, 1))
    for process in processes:
        transition = np.asarray(np.kron(transition, process.transition), dtype=np.float64)
        emission = np.asarray(np.kron(emission, process.emission), dtype=np.float64)
    events = tuple(itertools.product(*(process.events for process in processes)))
    return Pattern(transition, emission, events, depth)
