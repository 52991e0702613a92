"""How long nothing new came while the way was open: no session is lost for longer than its path."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence

from tests.support.link.attacker import Attacker
from tests.support.link.whole import MILLISECOND, Station, World

BACK = 1200 * MILLISECOND
"""Until two that run, and reach each other, have heard each other again."""
Times = tuple[int, int]


def without(spans: Iterable[Times], closed: Iterable[Times]) -> list[Times]:
    """What is left of ``spans`` outside ``closed``."""
    left = list(spans)
    for begin, end in closed:
        left = [
            piece
            for first, last in left
            for piece in ((first, min(last, begin)), (max(first, end), last))
            if piece[0] < piece[1]
        ]
    return left


def closed_by(attacker: Attacker) -> list[Times]:
    """When a way was silent, or what went it was held back."""
    return [(span.begin, span.end) for span in attacker.blackholes + attacker.bursts]


def longest_silence(news: Sequence[int], spans: Iterable[Times]) -> int:
    """The longest part without news of ``spans``, in which something new might have come."""
    longest = 0
    for begin, end in spans:
        marks = [begin, *(at for at in news if begin < at < end), end]
        longest = max([longest, *(b - a for a, b in itertools.pairwise(marks))])
    return longest


def check_silences(world: World, attacker: Attacker) -> None:
    """Between any two lives of any two stations of a simulated world."""
    for station in world.everybody:
        for peer, samples in station.samples.items():
            if not samples:
                continue
            news = [b.true for a, b in itertools.pairwise(samples) if b.sampled != a.sampled]
            others = [life for life in world.everybody if life.name == peer]
            both = [both_ran(station, other) for other in others if other.samples[station.name]]
            spans = without(both, closed_by(attacker))
            silence = longest_silence(news, spans)
            assert silence <= BACK, f"{station.name} heard nothing of {peer} for {silence} ns"


def both_ran(one: Station, other: Station) -> Times:
    """Empty, with the end before the begin, where they never ran at one time."""
    ran = [
        (seen[0].true, seen[-1].true) for seen in (one.samples[other.name], other.samples[one.name])
    ]
    return max(ran[0][0], ran[1][0]), min(ran[0][1], ran[1][1])
