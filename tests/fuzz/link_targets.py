"""The link between workstations: data packets, handshake, start, relay, contract, key file."""

from __future__ import annotations

import functools
import zlib
from fractions import Fraction
from pathlib import Path

import numpy as np

from cosim.base.errors import InputError
from cosim.link.netchar.relay import Caps, Relay
from cosim.link.session.asker import RETRY
from cosim.link.session.contract import Contract
from cosim.link.session.greeting import GREETING_SIZE
from cosim.link.session.keys import PreSharedKey, read_key_file
from cosim.link.session.negotiator import SessionNegotiator, side_of
from cosim.link.session.start import KEEP_INTERVAL, Side, StartAgreement
from cosim.link.stream.fate import Fate
from cosim.link.stream.receiver import Receiver, ReceiverSettings
from cosim.link.wire.packet import DataWriter, Opener, Sealer
from tests.fuzz.script import Script, spoil
from tests.support.link.support import KEY, TICK, both_ends, make_pair, small_bundle
from tests.support.scratch import scratch_folder

SENDER = ("127.0.0.1", 47000)


def data_packets(data: bytes) -> None:
    """What is not, to the last bit, a packet that was sealed changes nothing but a counter."""
    script = Script(data)
    pair = make_pair()
    good = {pair.packet(8 * n, 0.01 * n) for n in range(1 + script.number(3))}
    before = pair.receiver.values.copy()
    for original in sorted(good):
        for _ in range(1 + script.number(3)):
            arrived = spoil(original, script)
            fate = pair.receiver.accept(memoryview(arrived), 8)
            if arrived not in good:
                assert fate in {Fate.FORGED, Fate.TRUNCATED, Fate.FOREIGN}
                assert not pair.receiver.release(100)
                assert np.array_equal(pair.receiver.values, before)
            elif fate is Fate.ACCEPTED:
                pair.receiver.release(100)
                before = pair.receiver.values.copy()
    fate = pair.receiver.accept(memoryview(script.rest()), 8)
    assert fate in {Fate.FORGED, Fate.TRUNCATED, Fate.FOREIGN}


def data_values(data: bytes) -> None:
    """A peer with the right key that sends nonsense: nothing implausible is ever shown."""
    script = Script(data)
    bundle = small_bundle()
    keys = both_ends()
    writer = DataWriter(Sealer(keys[0].outgoing, keys[0].session), 0, bundle.size, bundle.head)
    receiver = Receiver(bundle, ReceiverSettings())
    receiver.offer(Opener(keys[1].incoming, keys[1].session))
    low, high = bundle.spread("minimum"), bundle.spread("maximum")
    now = 0
    while script.left:
        content = script.take(8 * bundle.size).ljust(8 * bundle.size, b"\0")
        writer.values[:] = np.frombuffer(content, "<f8")
        if script.number(2):
            writer.values[:] = np.remainder(np.nan_to_num(writer.values), 1.0)
        tick = int.from_bytes(script.take(8), "little", signed=True)
        tick = now if script.number(2) else tick
        numbers = np.frombuffer(script.take(56).ljust(56, b"\0"), "<i8")
        sent, echo_sent, echo_received, epoch, acknowledged, flags, content = map(int, numbers)
        writer.seal(
            tick,
            sent,
            echo_sent=echo_sent,
            echo_received=echo_received,
            epoch=epoch,
            acknowledged=(7, acknowledged),
            flags=flags & 0xFFFFFFFF if script.number(2) else flags & 7,
            content=content if script.number(2) else None,
        )
        receiver.accept(memoryview(bytes(writer.datagram)), now)
        now += script.number(20)
        if receiver.release(now):
            assert np.all((receiver.values >= low) & (receiver.values <= high))
            assert receiver.tick <= now + receiver.settings.early


def handshakes(data: bytes) -> None:
    """A spoiled or invented message is dropped, counted, and answered by nobody."""
    script = Script(data)
    sides = {"b": _side("b", "a"), "a": _side("a", "b")}
    message, now, turn, honest = sides["b"].poll(0)[0], 0, "a", set[bytes]()
    for _ in range(8):
        if message is not None:
            honest.add(message)
        for attack in (_spoiled(message, script), script.take(script.number(64)).ljust(1200)):
            if attack in honest or attack is None:
                continue
            side = sides[turn]
            dropped, session = side.drops.total, side.current
            assert side.receive(attack, now, now).answer is None
            assert side.drops.total == dropped + 1
            assert side.current is session
            assert side.refusal is None
        if message is None or script.number(8) == 1:
            now += RETRY
            message, turn = next(iter(sides["b"].poll(now)), None), "a"
            continue
        message = sides[turn].receive(message, now, now).answer
        turn = "b" if turn == "a" else "a"
    sessions = {side.current.keys.session for side in sides.values() if side.current is not None}
    assert len(sessions) <= 1


def starts(data: bytes) -> None:
    """Spoiled messages between two that hold a session: no exception, no start of their making."""
    script = Script(data)
    a, b = _met()
    now = 40 * KEEP_INTERVAL
    for _ in range(6):
        now += KEEP_INTERVAL
        for receiver, sender in ((a, b), (b, a)):
            for _, message in sender.poll(now):
                spoiled = spoil(message, script, 2)
                dropped = receiver.side(sender.own).drops.total
                start = receiver.start
                answer = receiver.receive(sender.own, spoiled, now, now)
                if spoiled != message:
                    assert answer is None
                    assert receiver.start is start
                    assert receiver.side(sender.own).drops.total > dropped
    a.receive("b", script.rest(), now, now)


def processes(data: bytes) -> None:
    """Any datagram at the handshake process: no answer, and no news for the loop."""
    script = Script(data)
    negotiator = _negotiator()
    while script.left:
        datagram = script.take(script.number(1300))
        datagram = datagram.ljust(GREETING_SIZE, b"\1") if script.number(2) else datagram
        if len(datagram) >= 24:
            assert negotiator.agreement.receive("b", datagram, 0, 0) is None
        assert not negotiator.news()


def relays(data: bytes) -> None:
    """The relay answers nobody who has not shaken hands with the key."""
    script = Script(data)
    relay = Relay(KEY, Caps())
    while script.left:
        datagram = script.take(script.number(1300))
        datagram = datagram.ljust(GREETING_SIZE, b"\1") if script.number(2) else datagram
        assert relay.take(memoryview(datagram), SENDER, 0, lambda: 0) is None
    assert relay.received == 0


def contracts(data: bytes) -> None:
    """A peer's packed contract is shown as text without control characters, whatever it is."""
    own = Contract({"rate": 128})
    for packed in (data, zlib.compress(data, 1), zlib.compress(data * 3000, 1)):
        for line in own.difference(Contract.unpack(packed), "a", "b"):
            assert line.isprintable()
    assert Contract.unpack(own.packed()) == own.entries


def key_files(data: bytes) -> None:
    """Any bytes in a key file are a key, or refused with a sentence."""
    path = _folder() / "key"
    path.write_bytes(data)
    path.chmod(0o600)
    try:
        assert isinstance(read_key_file(path), PreSharedKey)
    except InputError:
        return


def _side(own: str, peer: str) -> Side:
    return side_of(own, peer, KEY, Contract({"rate": 128}))


def _spoiled(message: bytes | None, script: Script) -> bytes | None:
    return None if message is None else spoil(message, script, 2)


def _met() -> tuple[StartAgreement, StartAgreement]:
    a, b = (
        StartAgreement(own=own, sides={peer: _side(own, peer)}, tick=TICK, period=8)
        for own, peer in (("a", "b"), ("b", "a"))
    )
    for step in range(8):
        now = step * KEEP_INTERVAL
        waiting = [(a, "b", m) for _, m in b.poll(now)] + [(b, "a", m) for _, m in a.poll(now)]
        while waiting:
            side, sender, message = waiting.pop(0)
            answer = side.receive(sender, message, now, now)
            if answer is not None:
                waiting.append((b if side is a else a, side.own, answer))
    assert a.sessions()
    assert b.sessions()
    return a, b


def _negotiator() -> SessionNegotiator:
    path = _folder() / "station.key"
    path.write_bytes(b"cohaptic-key-1 " + b"Q" * 42 + b"A=")
    path.chmod(0o600)
    return SessionNegotiator(
        {
            "own": "a",
            "peers": ["b"],
            "key_files": [str(path)],
            "contracts": [{"rate": 128}],
            "tick": str(Fraction(1, 1024)),
            "period": 8,
        }
    )


@functools.cache
def _folder() -> Path:
    return scratch_folder("fuzz")


TARGETS = {
    each.__name__: each
    for each in (
        data_packets,
        data_values,
        handshakes,
        starts,
        processes,
        relays,
        contracts,
        key_files,
    )
}
