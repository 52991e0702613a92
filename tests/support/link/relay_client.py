"""A client of a relay, by function calls."""

from __future__ import annotations

from cosim.link.netchar.relay import CLIENT, CONTRACT, OVERHEAD, PROBE, SERVER, Relay
from cosim.link.session.asker import Asker
from cosim.link.wire.packet import Opener, PacketKind, Sealer
from tests.support.link.support import KEY


class Session:
    """A client that shakes hands with a relay by function calls."""

    def __init__(self, relay: Relay, sender=("127.0.0.1", 5000), now: int = 0) -> None:
        self.relay, self.sender = relay, sender
        self.asker = Asker(own=CLIENT, peer=SERVER, key=KEY, contract=CONTRACT)
        (message,) = self.asker.poll(now)
        self.greetings = [message]
        while message is not None:
            answer = relay.take(memoryview(message), sender, now, lambda: now)
            message = None
            if answer is not None:
                message = self.asker.receive(bytes(answer), now, now).answer
                self.greetings += [] if message is None else [message]
        keys = None if self.asker.current is None else self.asker.current.keys
        self.connected = keys is not None
        if keys is not None:
            self.sealer = Sealer(keys.outgoing, keys.session)
            self.opener = Opener(keys.incoming, keys.session)

    def probe(self, sent: int, size: int = 100) -> bytes:
        plain = bytearray(size - OVERHEAD)
        PROBE.pack_into(plain, 0, sent)
        datagram = bytearray(size)
        self.sealer.seal(PacketKind.PROBE, 0, memoryview(plain), memoryview(datagram))
        return bytes(datagram)

    def ask(self, datagram: bytes, at: int, sender=None) -> bytes | None:
        answer = self.relay.take(memoryview(datagram), sender or self.sender, at, lambda: at)
        return None if answer is None else bytes(answer)
