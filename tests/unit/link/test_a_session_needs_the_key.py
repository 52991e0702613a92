"""A session needs the key, fresh keys of both ends and one contract; forged bytes bring nothing."""

from __future__ import annotations

import random
import struct

import pytest
from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.link.session.answerer import LARGEST_PENDING, PENDING_LIFE, Answerer
from cosim.link.session.asker import RETRY, SILENCE, Asker
from cosim.link.session.contract import Contract
from cosim.link.session.greeting import GREETING_SIZE, SIZES, question_of
from cosim.link.session.keys import prologue
from cosim.link.session.live import KEEP_SIZE, SessionState
from cosim.link.session.noise import NoiseError, NoiseHandshake
from cosim.link.wire.packet import HEADER, PacketKind, Sealer
from tests.support.link.support import KEY, OTHER_KEY

CONTRACT = Contract({"rate": 128, "gains": {"k": 800.0, "b": 3.0}})
MILLISECOND = 10**6


def asker(seed: int = 0, contract: Contract = CONTRACT, key=KEY) -> Asker:
    source = random.Random(("b", seed).__repr__())
    return Asker(own="b", peer="a", key=key, contract=contract, random=source.randbytes)


def answerer(seed: int = 0, contract: Contract = CONTRACT, key=KEY, **settings_) -> Answerer:
    source = random.Random(("a", seed).__repr__())
    return Answerer(
        own="a", peer="b", key=key, contract=contract, random=source.randbytes, **settings_
    )


def exchange(b: Asker, a: Answerer, now: int = 0, log: list | None = None) -> None:
    """Carry messages to and fro until nobody has anything to say."""
    log = [] if log is None else log
    waiting = [(a, message) for message in b.poll(now)]
    while waiting:
        receiver, message = waiting.pop(0)
        log.append(message)
        outcome = receiver.receive(message, now, now)
        answer = outcome.answer
        if outcome.keep is not None and receiver is a:
            answer = a.current.write(now, 0, SessionState.NONE)
        if answer is not None:
            waiting.append((b if receiver is a else a, answer))


def met(seed: int = 0) -> tuple[Asker, Answerer]:
    b, a = asker(seed), answerer(seed)
    exchange(b, a)
    assert b.current is not None
    assert a.current is not None
    return b, a


def test_a_question_an_answer_and_a_sealed_packet_each_way_make_a_session() -> None:
    b, a = asker(), answerer()
    log: list[bytes] = []
    exchange(b, a, log=log)
    kinds = [PacketKind(message[3]) for message in log]
    assert kinds == [PacketKind.HELLO, PacketKind.REPLY, PacketKind.KEEP, PacketKind.KEEP]
    assert [len(message) for message in log] == [1200, 1200, KEEP_SIZE, KEEP_SIZE]
    assert a.current.keys.session == b.current.keys.session
    assert a.current.keys.outgoing == b.current.keys.incoming
    assert a.current.keys.incoming == b.current.keys.outgoing


def test_no_answer_is_larger_than_its_question() -> None:
    assert {SIZES[kind] for kind in (PacketKind.HELLO, PacketKind.REPLY, PacketKind.REFUSE)} == {
        GREETING_SIZE
    }
    assert max(SIZES.values()) == GREETING_SIZE


def test_neither_the_key_nor_a_session_key_travels() -> None:
    b, a = asker(), answerer()
    log: list[bytes] = []
    exchange(b, a, log=log)
    secrets = [bytes(range(32)), a.current.keys.outgoing, a.current.keys.incoming]
    assert not any(secret in message for secret in secrets for message in log)


def test_a_recorded_session_cannot_be_opened_with_the_key_that_leaks_later() -> None:
    """All that travelled and the pre-shared key open the first payload, and no more."""
    b, a = asker(), answerer()
    log: list[bytes] = []
    exchange(b, a, log=log)
    values = b.current.write(5 * MILLISECOND, 7, SessionState.RUNNING)
    psk = KEY.derive("noise", context=prologue("a", "b"))

    def noise(message: bytes) -> bytes:
        return message[24:56] + message[72:-32]

    thief = NoiseHandshake(initiator=False, psk=psk, prologue=prologue("a", "b"))
    payload = thief.read(noise(log[0]))
    assert payload[:32] == CONTRACT.hash
    # The first message's key depends on the pre-shared key alone; from the second on it does not.
    thief.write(b"")
    guesses = [*thief.split(), psk, KEY.derive("noise")]
    impostor = NoiseHandshake(initiator=True, psk=psk, prologue=prologue("a", "b"))
    impostor.write(payload)
    with pytest.raises(NoiseError):
        impostor.read(noise(log[1]))
    guesses.append(X25519PrivateKey.generate().private_bytes_raw())
    for recorded in (*log[2:], values):
        _, _, kind, stream, _, _, sequence = HEADER.unpack_from(recorded)
        nonce = struct.pack("<BBHQ", kind, 0, stream, sequence)
        for guess in guesses:
            with pytest.raises(InvalidTag):
                AESGCM(guess).decrypt(nonce, recorded[24:], recorded[:24])
    # That the same bytes do open with what the two ends came to shows that the test looks right.
    assert AESGCM(a.current.keys.incoming).decrypt(
        struct.pack("<BBHQ", PacketKind.KEEP, 0, 0, 1), values[24:], values[:24]
    )


def test_another_key_gets_no_answer() -> None:
    b, a = asker(key=OTHER_KEY), answerer()
    (message,) = b.poll(0)
    assert a.receive(message, 0, 0).answer is None
    assert a.drops.foreign == 1


def test_a_message_sent_back_to_its_sender_is_known_as_its_own() -> None:
    b = asker()
    (message,) = b.poll(0)
    assert b.receive(message, 0, 0).answer is None
    assert (b.drops.foreign, b.drops.same_name) == (1, 1)


@settings(deadline=None, max_examples=80)
@given(message=st.integers(0, 3), place=st.integers(0, GREETING_SIZE - 1), bit=st.integers(0, 7))
def test_a_changed_bit_in_any_message_makes_it_worthless(message, place, bit) -> None:
    log: list[bytes] = []
    exchange(asker(), answerer(), log=log)
    b, a = asker(), answerer()
    before: list[bytes] = []
    sides = (a, b)
    waiting = b.poll(0)
    for number in range(message):
        before.append(waiting[0])
        outcome = sides[number % 2].receive(waiting[0], 0, 0)
        answer = outcome.answer
        if outcome.keep is not None and sides[number % 2] is a:
            answer = a.current.write(0, 0, SessionState.NONE)
        waiting = [answer]
    assert waiting == [log[message]]
    changed = bytearray(waiting[0])
    changed[place % len(changed)] ^= 1 << bit
    receiver = sides[message % 2]
    sessions = (receiver.current, receiver.previous)
    outcome = receiver.receive(bytes(changed), 0, 0)
    assert outcome.answer is None
    assert outcome.keep is None
    assert (receiver.current, receiver.previous) == sessions
    assert receiver.drops.total == 1


@settings(deadline=None, max_examples=50)
@given(noise=st.binary(max_size=1300))
def test_noise_is_dropped(noise: bytes) -> None:
    b, a = asker(), answerer()
    for side in (a, b):
        assert side.receive(noise, 0, 0).answer is None
        assert side.current is None


def test_a_recorded_handshake_played_again_neither_starts_nor_replaces_a_session() -> None:
    log: list[bytes] = []
    b, a = asker(1), answerer(1)
    exchange(b, a, log=log)
    live = a.current
    for now in (1, SILENCE, PENDING_LIFE, 10 * PENDING_LIFE):
        for message in log:
            a.receive(message, now, now)
            b.receive(message, now, now)
        assert a.current is live
    fresh_b, fresh_a = asker(2), answerer(2)
    fresh_b.poll(0)
    for message in log:
        fresh_a.receive(message, 1, 1)
        fresh_b.receive(message, 1, 1)
    assert (fresh_a.current, fresh_b.current) == (None, None)


def test_an_answer_to_the_same_question_is_the_same_answer() -> None:
    b, a = asker(), answerer()
    (hello,) = b.poll(0)
    replies = {
        a.receive(hello, now, now).answer for now in range(0, PENDING_LIFE, PENDING_LIFE // 50)
    }
    assert len(replies) == 1


def test_a_session_that_was_kept_back_does_not_replace_a_newer_one() -> None:
    b, a = asker(), answerer()
    (hello,) = b.poll(0)
    reply = a.receive(hello, 0, 0).answer
    withheld = b.receive(reply, 0, 0).answer
    # Nothing comes of it, so the asker begins anew a second later.
    exchange(b, a, now=SILENCE + 1)
    live = a.current
    assert live is not None
    assert a.receive(withheld, SILENCE + 2, SILENCE + 2).keep is None
    assert a.current is live


def test_a_live_session_is_kept_until_the_first_packet_under_the_new_one() -> None:
    b, a = met()
    old = a.current
    later = SILENCE + 1
    (hello,) = b.poll(later)
    reply = a.receive(hello, later, later).answer
    assert a.current is old
    keep = b.receive(reply, later, later).answer
    assert b.current.keys.session == old.keys.session
    assert a.receive(keep, later, later).keep is not None
    assert a.current.keys.session != old.keys.session
    assert a.previous is old
    # What the asker says under the session before is read on.
    heard = old.heard
    late = b.current.write(later, 0, SessionState.NONE)
    a.receive(late, later + 1, later + 1)
    assert old.heard > heard
    answer = a.current.write(later, 0, SessionState.NONE)
    assert b.receive(answer, later, later).keep is not None
    assert b.current.keys.session == a.current.keys.session


@pytest.mark.parametrize(("place", "value"), [(32, 8), (33, 1), (36, 1), (39, 128)])
def test_a_keep_that_says_more_than_it_may_is_no_life(place: int, value: int) -> None:
    b, a = met()
    assert b.current is not None
    plain = bytearray(40)
    plain[place] = value
    datagram = bytearray(KEEP_SIZE)
    Sealer.seal(b.current._sealer, PacketKind.KEEP, 0, memoryview(plain), memoryview(datagram))
    before = a.drops.stray
    assert a.receive(bytes(datagram), MILLISECOND, MILLISECOND).keep is None
    assert a.drops.stray == before + 1


@pytest.mark.parametrize("spoil", ["padding", "reason", "piece"])
def test_a_question_that_says_more_than_it_may_gets_no_answer(spoil: str) -> None:
    b, a = asker(), answerer()
    b._ask()
    noise = NoiseHandshake(
        initiator=True, psk=b._psk, prologue=b._prologue, ephemeral=bytes(range(32))
    )
    content = bytearray(b._contracts.payload().pack())
    if spoil == "padding":
        content[-1] = 1
    elif spoil == "reason":
        content[46] = 1
    else:
        content[40] = 200
    message = noise.write(bytes(content))
    hello = b._greeter.write(PacketKind.HELLO, question_of(noise.public), message)
    assert a.receive(hello, 0, 0).answer is None
    assert a.drops.foreign == 1


def test_a_word_of_presence_asks_nothing() -> None:
    b, a = asker(), answerer()
    assert b.receive(a._greeter.write(PacketKind.PRESENT, 0), 0, 0).answer is None
    assert b.drops.total == 0
    b.receive(a._greeter.write(PacketKind.PRESENT, 7), 0, 0)
    assert b.drops.total == 1


def test_replays_and_second_copies_are_no_life() -> None:
    b, a = met()
    copies = [a.current.write(now, 0, SessionState.NONE) for now in (1, 2)]
    for now in range(0, SILENCE, SILENCE // 100):
        for message in copies:
            b.receive(message, now, now)
    assert any(message[3] == PacketKind.HELLO for message in b.poll(SILENCE + 10 * MILLISECOND))


def test_what_is_never_acknowledged_asks_again_although_it_is_heard() -> None:
    b, a = met()
    for now in range(0, SILENCE + 5 * MILLISECOND, 10 * MILLISECOND):
        b.receive(a.current.write(now, 0, SessionState.NONE), now, now)
    assert b.current.heard > SILENCE - 10 * MILLISECOND
    assert any(message[3] == PacketKind.HELLO for message in b.poll(SILENCE + 10 * MILLISECOND))


def test_a_candidate_that_nobody_answers_is_given_up_after_a_second() -> None:
    b, a = asker(), answerer()
    (hello,) = b.poll(0)
    b.receive(a.receive(hello, 0, 0).answer, 0, 0)
    sent = [m for now in range(RETRY, SILENCE + 1, RETRY) for m in b.poll(now)]
    assert {m[3] for m in sent} == {PacketKind.KEEP}
    (again,) = b.poll(SILENCE + RETRY)
    assert again[3] == PacketKind.HELLO
    assert again != hello


def test_recorded_questions_do_not_keep_a_restarted_answerer_from_an_honest_one() -> None:
    """From the fourth on a cookie is asked for, which only who is there and asks now can get."""
    recorded = [asker(seed).poll(0)[0] for seed in range(100, 200)]
    b, a = asker(), answerer()
    now = 0
    while a.current is None:
        now += 10 * MILLISECOND
        assert now < SILENCE, "the honest one is kept out"
        a.receive(recorded[now // (10 * MILLISECOND) % 100], now, now)
        exchange(b, a, now)
    assert b.current.keys.session == a.current.keys.session


def test_entries_that_nobody_confirms_are_few_and_forgotten() -> None:
    a = answerer()
    for seed in range(50):
        b = asker(seed)
        now = seed * 20 * MILLISECOND
        outcome = a.receive(b.poll(now)[0], now, now)
        if outcome.answer[3] == PacketKind.COOKIE:
            question = b.receive(outcome.answer, now, now).answer
            assert a.receive(question, now, now).answer[3] == PacketKind.REPLY
        assert len(a._pending) <= LARGEST_PENDING
    a.poll(PENDING_LIFE + 1000 * MILLISECOND)
    assert a._pending == []


def test_a_cookie_is_good_for_its_address_and_its_question_and_not_for_ever() -> None:
    a = answerer(proof_of_address=True)
    b = asker()
    (hello,) = b.poll(0)
    cookie = a.receive(hello, 0, 0, b"here").answer
    assert cookie[3] == PacketKind.COOKIE
    assert len(cookie) < len(hello)
    question = b.receive(cookie, 0, 0).answer
    assert a.receive(question, 0, 0, b"there").answer[3] == PacketKind.COOKIE
    other = asker(1)
    (hello,) = other.poll(0)
    stolen = hello[:56] + question[56:72] + hello[72:]
    assert a.receive(stolen, 0, 0, b"here").answer is None
    much_later = 41 * 10**9
    assert a.receive(question, much_later, much_later, b"here").answer[3] == PacketKind.COOKIE
    assert a.receive(b.poll(much_later)[0], much_later, much_later, b"here").answer is not None


def test_greetings_beyond_a_budget_cost_no_key_agreement() -> None:
    a = answerer(contract=Contract({"rate": 64}))
    hellos = [asker(seed).poll(0)[0] for seed in range(100)]
    answers = [a.receive(hello, 0, 0).answer for hello in hellos]
    assert sum(answer is not None for answer in answers) == 32
    assert a.drops.too_many == 68


@pytest.mark.parametrize("extra", [0, 400])
def test_a_different_contract_is_refused_with_the_difference_on_both_sides(extra: int) -> None:
    """Also where the contract takes several messages."""
    filler = {f"parameter_{number}": number**2.5 for number in range(extra)}
    mine = Contract({"rate": 128, "gains": {"k": 800.0, "b": 3.0}, **filler})
    theirs = Contract({"rate": 64, "gains": {"k": 800, "m": 1}, **filler})
    b, a = asker(contract=mine), answerer(contract=theirs)
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
    assert (a.current, b.current) == (None, None)


def test_contracts_are_equal_whatever_the_order_and_type_of_equal_numbers() -> None:
    assert Contract({"a": 1, "b": [1.0, 2]}).hash == Contract({"b": [1, 2.0], "a": 1.0}).hash
    assert Contract({"a": 1}).hash != Contract({"a": 1.0000000000000002}).hash
    assert Contract({"a": {"b": 1}}).hash == Contract({"a.b": 1}).hash
    assert Contract({"a": 2**60}).hash != Contract({"a": 2**60 + 1}).hash


def test_indices_are_in_the_order_of_numbers() -> None:
    contract = Contract({"gain": list(range(11))})
    assert list(contract.entries)[:4] == ["gain[1]", "gain[2]", "gain[3]", "gain[4]"]
    assert list(contract.entries)[-2:] == ["gain[11]", "protocol"]


def test_a_peer_cannot_write_on_the_terminal() -> None:
    lines = CONTRACT.difference({"\x1b[2J": "\x1b]0;x\x07", "9" * 10_000: "x"}, "a", "b")
    assert all(line.isprintable() for line in lines)
