"""Whatever comes to a relay or to who measures is answered, used, or counted; people are told."""

from __future__ import annotations

from cosim.link.netchar.measurement import NetworkMeasurement
from cosim.link.netchar.probe import Probe
from cosim.link.netchar.relay import CLIENT, CONTRACT, SERVER, Caps, Relay
from cosim.link.session.answerer import Answerer
from cosim.link.session.asker import Asker
from cosim.link.session.greeting import SIZES
from cosim.link.wire.address import Address
from cosim.link.wire.sockets import open_socket
from tests.support.link.relay_client import Session
from tests.support.link.support import KEY, OTHER_KEY

STRANGER = ("10.0.0.9", 1)
HEAD = b"cH\2"


def greeting(key=OTHER_KEY) -> bytes:
    return Asker(own=CLIENT, peer=SERVER, key=key, contract=CONTRACT).poll(0)[0]


def test_every_datagram_is_answered_or_counted() -> None:
    """Greetings of every kind, copies and noise of each size, from the asker and from others."""
    relay = Relay(KEY, Caps(rate=100.0))
    session = Session(relay)
    probes = [session.probe(number) for number in range(200)]
    noise = [HEAD + bytes([kind]) + bytes(size - 4) for kind in range(40) for size in SIZES]
    given = [
        *session.greetings,
        *session.greetings,
        greeting(),
        *probes,
        probes[0],
        *noise,
        b"",
        b"c",
    ]
    own = Answerer(own=SERVER, peer=CLIENT, key=KEY, contract=CONTRACT).poll(0)
    before = relay.received
    answers = 0
    for sender in (session.sender, STRANGER):
        answers += sum(session.ask(one, 10**9, sender) is not None for one in [*given, *own])
    counted = relay.dropped + relay.capped + relay.handshakes_failed
    assert answers >= relay.received - before > 0
    assert answers + counted == 2 * (len(given) + len(own))


def test_what_only_looks_like_a_greeting_is_counted() -> None:
    with open_socket(Address("127.0.0.1", 0), None) as link:
        probe, session = Probe(link, KEY), Session(Relay(KEY, Caps()))
        probe.converse(session.asker.current.keys)
        found = NetworkMeasurement(100.0, 280)
        for kind in range(16, 22):
            for size in (24, 80, *SIZES):
                junk = HEAD + bytes([kind]) + bytes(size - 4)
                probe._take(memoryview(junk), found)
    assert found.forged > found.greetings
    assert found.forged + found.greetings == 6 * (2 + len(SIZES))


def told(relay: Relay, *datagrams: bytes) -> list[str]:
    for datagram in datagrams:
        relay.take(memoryview(datagram), STRANGER, 1, lambda: 1)
    return relay.notes()


def test_who_serves_is_told_once_of_another_key() -> None:
    relay = Relay(KEY, Caps())
    assert told(relay, greeting()) == []
    (sentence,) = told(relay, *[greeting()] * 10)
    assert "does not fit the key" in sentence
    assert told(relay, *[greeting()] * 10) == []


def test_who_serves_is_told_once_of_another_version_and_of_nothing_that_is_not_true() -> None:
    relay = Relay(KEY, Caps())
    old = b"cH\1" + greeting(KEY)[3:]
    (sentence,) = told(relay, *[old] * 10)
    assert "version 1 of the link's protocol" in sentence
    assert "key" not in sentence
    assert told(relay, *[b"cH\3" + old[3:]] * 10) == []


def test_who_serves_is_told_once_of_others_that_wait() -> None:
    relay = Relay(KEY, Caps())
    session = Session(relay)
    assert session.ask(session.probe(1), 2) is not None
    assert relay.notes() == []
    for port in range(3):
        assert Session(relay, ("10.0.0.9", port), now=10**8).asker.busy
    (sentence,) = relay.notes()
    assert "is told to wait" in sentence
    assert relay.refused == 3
