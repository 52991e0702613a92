"""A man in the middle without the key: what he does to datagrams, drawn from a seed."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field

from cosim.link.wire.packet import PacketKind
from tests.support.link.whole import MILLISECOND, SECOND, World

CALM = 9 * SECOND
WAY = 3 * MILLISECOND


@dataclass
class Span:
    """A time in which a direction (or both: ``None``) suffers something."""

    begin: int
    end: int
    source: str | None = None

    def covers(self, source: str, now: int) -> bool:
        return self.begin <= now < self.end and self.source in {None, source}


@dataclass
class Attacker:
    """Treats datagrams for a :class:`~tests.support.link.whole.Wire`."""

    seed: int
    names: list[str]
    recorded: list[tuple[str, str, bytes]] = field(default_factory=list)
    """Handshake messages: source, target, content."""
    way: int = WAY
    calm: int = CALM
    """From here on he lets everything pass, as it comes."""

    def __post_init__(self) -> None:
        draw = self.draw = random.Random(self.seed)
        self.withholds = draw.random() < 0.3
        """Keeps the first keep after every reply, and lets it go later."""
        self.drops = draw.choice([0.0, 0.0, 0.2, 0.5])
        self.holds = draw.choice([0.0, 0.2, 0.5])
        self.copies = draw.choice([0.0, 0.3])
        self.flips = draw.choice([0.0, 0.1])
        self.loss = draw.choice([0.0, 0.01, 0.05])
        self.jitter = draw.choice([0, MILLISECOND, 6 * MILLISECOND])
        self.blackholes = [self._span(3 * SECOND) for _ in range(draw.choice([0, 0, 1, 2]))]
        self.bursts = [self._span(300 * MILLISECOND) for _ in range(draw.choice([0, 1, 3]))]
        self.replays = [self._span(4 * SECOND) for _ in range(draw.choice([0, 1]))]
        self.withheld: set[bytes] = set()

    def _span(self, longest: int) -> Span:
        begin = self.draw.randrange(0, self.calm - longest)
        source = self.draw.choice([None, *self.names])
        return Span(begin, begin + self.draw.randrange(longest // 10, longest), source)

    def treat(self, source: str, target: str, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        draw = self.draw
        if now >= self.calm:
            return [(now + self.way, datagram)]
        if any(span.covers(source, now) for span in self.blackholes):
            return []
        is_value = datagram[3] == PacketKind.DATA
        if not is_value:
            self.recorded.append((source, target, datagram))
        if draw.random() < (self.loss if is_value else self.drops):
            return []
        due = now + self.way + draw.randrange(self.jitter + 1)
        for span in self.bursts:
            if span.covers(source, now):
                due = max(due, span.end)
        if not is_value:
            if draw.random() < self.holds:
                due = now + draw.randrange(7 * SECOND)
            if (
                self.withholds
                and datagram[3] == PacketKind.KEEP
                and datagram[8:16] not in self.withheld
            ):
                self.withheld.add(datagram[8:16])
                due = now + draw.randrange(SECOND, 6 * SECOND)
        out = [(due, datagram)]
        if draw.random() < self.copies:
            out += [
                (due + draw.randrange(3 * SECOND), datagram) for _ in range(draw.randrange(1, 4))
            ]
        if draw.random() < self.flips:
            changed = bytearray(datagram)
            changed[draw.randrange(len(changed))] ^= 1 << draw.randrange(8)
            out.append((due, bytes(changed)))
        return out

    def restarts(self) -> list[tuple[str, int, int]]:
        """Who is killed when, and for how long he is away."""
        draw, out = self.draw, []
        for name in self.names:
            if draw.random() < 0.4:
                pause = draw.choice([0, 200 * MILLISECOND, 1500 * MILLISECOND])
                out.append((name, draw.randrange(SECOND // 5, self.calm - 2 * SECOND), pause))
        return out

    def events(self, world: World) -> list[tuple[int, Callable[[], None]]]:
        """Restarts, and greetings replayed at 100 a second."""
        draw = self.draw
        out: list[tuple[int, Callable[[], None]]] = []

        def restart(name: str, at: int, pause: int) -> None:
            out.append((at, lambda: world.kill(name)))
            out.append((at + pause, lambda: None if name in world.stations else world.start(name)))

        for name, at, pause in self.restarts():
            restart(name, at, pause)

        def replay() -> None:
            greetings = [m for m in self.recorded if m[2][3] <= PacketKind.COOKIE]
            if greetings:
                source, target, content = draw.choice(greetings[-50:])
                world.wire.put(world.wire.now + MILLISECOND, source, target, content)

        for span in self.replays:
            out += [(at, replay) for at in range(span.begin, span.end, 10 * MILLISECOND)]
        return out


class Hardest(Attacker):
    """What is hardest in one schedule; drawn is only which datagrams it happens to."""

    def __post_init__(self) -> None:
        super().__post_init__()
        answerer, asker = sorted(self.names)
        self.calm = 8 * SECOND
        self.withholds = True
        self.drops, self.holds, self.copies, self.flips = 0.2, 0.2, 0.3, 0.1
        self.loss, self.jitter = 0.02, 2 * MILLISECOND
        self.replays = [Span(SECOND, self.calm)]
        self.bursts = [Span(7000 * MILLISECOND, 7300 * MILLISECOND)]
        # While they meet; before the answerer is gone, and when he is there again.
        self.blackholes = [
            Span(200 * MILLISECOND, 500 * MILLISECOND),
            Span(2000 * MILLISECOND, 2400 * MILLISECOND, answerer),
            Span(6200 * MILLISECOND, 6600 * MILLISECOND, asker),
        ]

    def restarts(self) -> list[tuple[str, int, int]]:
        """The answerer, while greetings are replayed to him a hundred times a second."""
        return [(min(self.names), 2500 * MILLISECOND, 0)]
