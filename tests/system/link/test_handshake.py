"""A session needs the key, both fresh nonces and one contract; forged bytes bring nothing."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.link.session.contract import Contract
from cosim.link.session.handshake import CONFIRM_TRIES, MESSAGE_SIZE, RETRY, SECRET_LIFE, Handshake
from cosim.link.wire.packet import HEADER, Kind
from tests.support.link.support import KEY, OTHER_KEY

CONTRACT = Contract({"rate": 128, "gains": {"k": 800.0, "b": 3.0}})


def side(own: str, peer: str, seed: int = 0, contract: Contract = CONTRACT, key=KEY) -> Handshake:
    numbers = itertools.count(seed * 1_000_000)
    return Handshake(
        own=own,
        peer=peer,
        key=key,
        contract=contract,
        nonce=lambda: (own + str(next(numbers))).encode().ljust(32, b"."),
    )


def pair(seed: int = 0) -> tuple[Handshake, Handshake]:
    return side("b", "a", seed), side("a", "b", seed)


def exchange(asker: Handshake, answerer: Handshake, now: int = 0, log: list | None = None) -> None:
    """Carry messages to and fro until nobody has anything to say."""
    message = asker.poll(now)
    while message is not None:
        if log is not None:
            log.append(message)
        answer = answerer.receive(message, now)
        if answer is None:
            return
        if log is not None:
            log.append(answer)
        message = asker.receive(answer, now)


def test_three_messages_and_an_acknowledgement_make_a_session() -> None:
    b, a = pair()
    log: list[bytes] = []
    exchange(b, a, log=log)
    kinds = [HEADER.unpack_from(message)[2] for message in log]
    assert kinds == [Kind.HELLO, Kind.REPLY, Kind.CONFIRM, Kind.ACKNOWLEDGE]
    assert a.session is not None
    assert b.session is not None
    assert a.session.session == b.session.session
    assert a.session.outgoing == b.session.incoming
    assert a.session.incoming == b.session.outgoing
    assert {len(message) for message in log} == {MESSAGE_SIZE}


def test_the_key_does_not_travel() -> None:
    b, a = pair()
    log: list[bytes] = []
    exchange(b, a, log=log)
    assert a.session is not None
    secrets = [bytes(range(32)), a.session.outgoing, a.session.incoming, a.session.confirmation]
    assert not any(secret in message for secret in secrets for message in log)


def test_another_key_gets_no_answer() -> None:
    b, a = side("b", "a", key=OTHER_KEY), side("a", "b")
    message = b.poll(0)
    assert message is not None
    assert a.receive(message, 0) is None
    assert a.dropped == 1


def test_a_message_sent_back_to_its_sender_is_dropped() -> None:
    b, _ = pair()
    message = b.poll(0)
    assert message is not None
    assert b.receive(message, 0) is None
    assert b.dropped == 1


@settings(deadline=None, max_examples=80)
@given(message=st.integers(0, 3), place=st.integers(0, MESSAGE_SIZE - 1), bit=st.integers(0, 7))
def test_a_changed_bit_in_any_message_makes_it_worthless(message, place, bit) -> None:
    log: list[bytes] = []
    exchange(*pair(), log=log)
    b, a = pair()
    changed = bytearray(log[message])
    changed[place] ^= 1 << bit
    receiver = a if message % 2 == 0 else b
    b.poll(0)
    assert receiver.receive(bytes(changed), 0) is None
    assert receiver.session is None


@settings(deadline=None, max_examples=50)
@given(noise=st.binary(max_size=1300))
def test_noise_is_dropped(noise: bytes) -> None:
    b, a = pair()
    assert a.receive(noise, 0) is None
    assert b.receive(noise, 0) is None
    assert (a.session, b.session) == (None, None)


def test_a_recorded_handshake_played_again_neither_starts_nor_replaces_a_session() -> None:
    log: list[bytes] = []
    b, a = pair(seed=1)
    exchange(b, a, log=log)
    live = a.session
    # Against the running station, against its asker, and against a restarted station.
    for message in log:
        a.receive(message, 1)
        b.receive(message, 1)
    assert a.session == live
    fresh_b, fresh_a = pair(seed=2)
    fresh_b.poll(0)
    for message in log:
        fresh_a.receive(message, 1)
        fresh_b.receive(message, 1)
    assert (fresh_a.session, fresh_b.session) == (None, None)


@pytest.mark.parametrize("pause", [0, SECRET_LIFE + 1, 2 * SECRET_LIFE + 1, 50 * SECRET_LIFE])
def test_a_replaced_session_cannot_be_confirmed_again(pause: int) -> None:
    """Its sequences would start again under the same key."""
    b, a = pair()
    log: list[bytes] = []
    exchange(b, a, log=log)
    old = a.session
    b.ask_again()
    exchange(b, a, now=RETRY)
    new = a.session
    assert new is not None
    assert old is not None
    assert new.session != old.session
    for message in log:
        a.receive(message, RETRY + pause)
    assert a.session == new


def test_a_live_session_is_kept_until_the_new_one_is_confirmed() -> None:
    b, a = pair()
    exchange(b, a)
    live, live_b = a.session, b.session
    b.ask_again()
    hello = b.poll(RETRY)
    assert hello is not None
    reply = a.receive(hello, RETRY)
    assert reply is not None
    assert a.session == live
    confirm = b.receive(reply, RETRY)
    assert b.session == live_b
    assert confirm is not None
    acknowledge = a.receive(confirm, RETRY)
    assert a.session != live
    assert acknowledge is not None
    b.receive(acknowledge, RETRY)
    assert b.session is not None
    assert a.session is not None
    assert b.session.session == a.session.session


def test_a_station_that_restarts_gets_a_session_with_other_keys() -> None:
    b, a = pair()
    exchange(b, a)
    first = a.session
    restarted = side("b", "a", seed=7)
    exchange(restarted, a, now=10**9)
    assert a.session is not None
    assert first is not None
    assert a.session.session != first.session
    assert a.session.incoming != first.incoming


def test_replayed_hellos_do_not_push_out_an_honest_one() -> None:
    b, a = pair()
    honest = b.poll(0)
    assert honest is not None
    reply = a.receive(honest, 0)
    for seed in range(3, 60):
        message = side("b", "a", seed).poll(0)
        assert message is not None
        a.receive(message, 1)
    assert reply is not None
    confirm = b.receive(reply, 2)
    assert confirm is not None
    assert a.receive(confirm, 3) is not None
    assert a.session is not None


def test_lost_messages_are_sent_again_and_a_dead_answerer_is_asked_anew() -> None:
    b, a = pair()
    hello = b.poll(0)
    assert hello is not None
    reply = a.receive(hello, 0)
    assert reply is not None
    first = b.receive(reply, 0)
    sent = [b.poll((number + 1) * RETRY) for number in range(CONFIRM_TRIES + 1)]
    assert sent[:CONFIRM_TRIES] == [first] * CONFIRM_TRIES
    last = sent[-1]
    assert last is not None
    assert HEADER.unpack_from(last)[2] == Kind.HELLO


@pytest.mark.parametrize("extra", [0, 400])
def test_a_different_contract_is_refused_with_the_difference_on_both_sides(extra: int) -> None:
    """Also where the contract takes several messages."""
    filler = {f"parameter_{number}": number**2.5 for number in range(extra)}
    mine = Contract({"rate": 128, "gains": {"k": 800.0, "b": 3.0}, **filler})
    theirs = Contract({"rate": 64, "gains": {"k": 800, "m": 1}, **filler})
    b, a = side("b", "a", contract=mine), side("a", "b", contract=theirs)
    for number in range(30):
        exchange(b, a, now=number * RETRY)
    assert b.refusal is not None
    assert b.refusal.differences == (
        "gains.b: 3.0 at b, absent at a",
        "gains.m: absent at b, 1.0 at a",
        "rate: 128.0 at b, 64.0 at a",
    )
    assert a.refusal is not None
    assert "rate: 64.0 at a, 128.0 at b" in a.refusal.differences
    assert (a.session, b.session) == (None, None)


def test_contracts_are_equal_whatever_the_order_and_type_of_equal_numbers() -> None:
    assert Contract({"a": 1, "b": [1.0, 2]}).hash == Contract({"b": [1, 2.0], "a": 1.0}).hash
    assert Contract({"a": 1}).hash != Contract({"a": 1.0000000000000002}).hash
    assert Contract({"a": {"b": 1}}).hash == Contract({"a.b": 1}).hash


def test_a_peer_cannot_write_on_the_terminal() -> None:
    lines = CONTRACT.difference({"\x1b[2J": "\x1b]0;x\x07"}, "a", "b")
    assert all(line.isprintable() for line in lines)
