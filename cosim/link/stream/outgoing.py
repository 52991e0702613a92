"""What goes to the peer: sealed at its samples, with what was heard of the peer's own packets."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cosim.link.session.keys import SessionKeys
from cosim.link.stream.bundle import PacketBundle
from cosim.link.stream.content import SentContent
from cosim.link.stream.path import Acknowledgements
from cosim.link.wire.packet import DataWriter, PacketFlag, Sealer
from cosim.link.wire.transport import Transport


class Outgoing:
    """Seals and sends the bundles of one direction; times in ns of the own clock."""

    def __init__(
        self,
        bundles: Sequence[PacketBundle],
        transport: Transport,
        newest: Callable[[int], tuple[int, int]],
    ) -> None:
        """``newest`` tells, by the number of a stream, what was received of the peer's last."""
        self.bundles = list(bundles)
        self.writers = [
            DataWriter(None, bundle.stream, bundle.size, bundle.head) for bundle in bundles
        ]
        self.contents = [SentContent(bundle) for bundle in bundles]
        self.session: SessionKeys | None = None
        """What is sent under."""
        self.sent = 0
        self.acknowledgements = Acknowledgements()
        self.first_sent: int | None = None
        """Session tick of the first packet of the run."""
        self.echo: tuple[int, int] = (0, 0)
        """When the peer sent its newest packet (its clock), and when that came."""
        self._transport, self._newest = transport, newest

    def use(self, keys: SessionKeys) -> None:
        """Send under a session from now on."""
        self.session = keys
        self.acknowledgements.begin(keys.session)
        sealer = Sealer(keys.outgoing, keys.session)
        for writer, content in zip(self.writers, self.contents, strict=True):
            writer.renew(sealer)
            content.begin(keys.session)

    def heard(self, stream: int, session: int, sequence: int) -> None:
        """The peer has received ``sequence`` of a session (its low half) on a stream."""
        if stream == 0:
            self.acknowledgements.heard(session, sequence)
        if stream < len(self.contents):
            self.contents[stream].acknowledged(session, sequence)

    def send(self, tick: int, now: int, epoch: int) -> None:
        """Send every bundle whose sample is due at ``tick``; fill ``writers[i].values`` before."""
        if self.session is None:
            return
        for bundle, writer, content in zip(self.bundles, self.writers, self.contents, strict=True):
            if tick % bundle.period == 0:
                since, withheld = content.of(tick, writer.values)
                flags = PacketFlag.WITHHELD if withheld else 0
                sequence = self._send(
                    bundle, writer, (tick, now), epoch=epoch, flags=flags, content=since
                )
                content.sent(sequence, withheld=withheld)
        if self.first_sent is None:
            self.first_sent = tick

    def send_flagged(self, flag: PacketFlag, tick: int, now: int, epoch: int) -> None:
        """Send all bundles, whatever the tick: before the start, or to announce the stop."""
        if self.session is None:
            return
        for bundle, writer in zip(self.bundles, self.writers, strict=True):
            self._send(bundle, writer, (tick, now), epoch=epoch, flags=flag)

    def _send(
        self,
        bundle: PacketBundle,
        writer: DataWriter,
        at: tuple[int, int],
        *,
        epoch: int,
        flags: int = 0,
        content: int | None = None,
    ) -> int:
        assert self.session is not None
        sequence = writer.seal(
            *at,
            echo_sent=self.echo[0],
            echo_received=self.echo[1],
            epoch=epoch,
            acknowledged=self._newest(bundle.stream),
            flags=flags,
            content=content,
        )
        if bundle.stream == 0:
            self.acknowledgements.sent(self.session.session, sequence, at[0])
        self.sent += self._transport.send(writer.datagram)
        return sequence
