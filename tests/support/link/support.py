"""Shared pieces: a bundle like that of two workstations, and both ends of a session's keys."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from cosim.link.session.keys import PreSharedKey, SessionKeys
from cosim.link.stream.bundle import Field, FieldRole, PacketBundle
from cosim.link.stream.receiver import Receiver, ReceiverSettings
from cosim.link.wire.packet import DataWriter, Opener, Sealer

TICK = Fraction(1, 1024)
PERIOD = 8
KEY = PreSharedKey(bytes(range(32)))
OTHER_KEY = PreSharedKey(bytes(range(1, 33)))


def small_bundle(source: str = "a", target: str = "b", stream: int = 0) -> PacketBundle:
    return PacketBundle(
        source=source,
        target=target,
        fields=(
            Field(name="vr.position", unit="m", size=2, minimum=-1.0, maximum=1.0, speed=3.0),
            Field(name="vr.velocity", unit="m/s", size=2, minimum=-20.0, maximum=20.0),
            Field(name="vr.source_tick", integer=True, role=FieldRole.SOURCE_TICK),
            Field(name="vr.source_age", integer=True, minimum=0, role=FieldRole.SOURCE_AGE),
            Field(name="vr.status", integer=True, minimum=0, role=FieldRole.STATUS),
        ),
        period=PERIOD,
        tick=TICK,
        stream=stream,
    )


def both_ends(
    key: PreSharedKey = KEY, names: tuple[str, str] = ("a", "b"), number: int = 0
) -> tuple[SessionKeys, SessionKeys]:
    """Keys as both ends of a handshake would come to, the first station's first."""
    about = str(number).encode()
    there, back = (key.derive(f"from {name}", context=about) for name in names)
    session = int.from_bytes(key.derive("session", context=about)[:8], "little")
    return SessionKeys(session, there, back), SessionKeys(session, back, there)


@dataclass
class Pair:
    """What a sends and what b receives, under one session."""

    writer: DataWriter
    receiver: Receiver

    def packet(self, tick: int, position: float = 0.0, **settings: int) -> bytes:
        self.writer.values[:] = 0.0
        self.writer.values[0] = position
        self.writer.values[4] = tick
        self.writer.seal(tick, settings.pop("sent", tick * 976_563), **settings)
        return bytes(self.writer.datagram)


def make_pair(settings: ReceiverSettings | None = None, key: PreSharedKey = KEY) -> Pair:
    bundle = small_bundle()
    a, b = both_ends(key)
    receiver = Receiver(bundle, settings or ReceiverSettings())
    receiver.offer(Opener(b.incoming, b.session))
    return Pair(DataWriter(Sealer(a.outgoing, a.session), 0, bundle.size, bundle.head), receiver)
