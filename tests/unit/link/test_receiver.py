"""The freshest authentic and sensible value wins; everything else is dropped and counted."""

from __future__ import annotations

import math
import tracemalloc

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cosim.base.component import Causality, Variable, VariableType
from cosim.link.stream.bundle import Field, PacketBundle
from cosim.link.stream.fate import Fate
from cosim.link.stream.receiver import Receiver, ReceiverSettings, Release
from cosim.link.wire.packet import HEADER, DataWriter, Opener, PacketFlag, Sealer, datagram_size
from cosim.link.wire.window import WINDOW
from tests.support.link.support import (
    OTHER_KEY,
    PERIOD,
    TICK,
    Pair,
    both_ends,
    make_pair,
    small_bundle,
)


def test_a_packet_is_shown_at_the_next_network_sample_and_not_before(pair: Pair) -> None:
    fate = pair.receiver.accept(memoryview(pair.packet(80, 0.01)), 81)
    assert fate is Fate.ACCEPTED
    assert not any(pair.receiver.release(tick) for tick in range(81, 88))
    assert pair.receiver.values[0] == 0.0
    assert pair.receiver.release(88)
    assert (pair.receiver.tick, pair.receiver.values[0]) == (80, 0.01)


def test_a_packet_of_the_same_tick_still_waits_one_sample(pair: Pair) -> None:
    """Two grids within a tick of each other: n must not flip between 0 and 1."""
    pair.receiver.accept(memoryview(pair.packet(80)), 80)
    assert not pair.receiver.release(80)
    assert pair.receiver.release(88)
    assert pair.receiver.overdue == 0


def test_release_on_arrival_shows_it_at_once() -> None:
    pair = make_pair(ReceiverSettings(release=Release.ARRIVAL))
    pair.receiver.accept(memoryview(pair.packet(80, 0.01)), 83)
    assert pair.receiver.release(83)
    assert pair.receiver.values[0] == 0.01


def test_a_longer_least_delay_absorbs_jitter_and_reordering() -> None:
    pair = make_pair(ReceiverSettings(delay=3))
    packets = {tick: pair.packet(tick) for tick in (0, 8, 16, 24)}
    arrivals = [(9, 8), (14, 0), (23, 24), (27, 16)]
    shown = []
    for now in range(64):
        for at, tick in arrivals:
            if at == now:
                pair.receiver.accept(memoryview(packets[tick]), now)
        if pair.receiver.release(now):
            shown.append((now, pair.receiver.tick))
    assert shown == [(24, 0), (32, 8), (40, 16), (48, 24)]
    assert pair.receiver.overdue == 0


@settings(deadline=None, max_examples=100)
@given(
    order=st.permutations(list(range(12))),
    gaps=st.lists(st.integers(0, 12), min_size=12, max_size=12),
)
def test_what_is_held_only_ever_gets_newer(order: list[int], gaps: list[int]) -> None:
    pair = make_pair()
    packets = [pair.packet(tick * PERIOD) for tick in range(12)]
    now, shown, arrived = 11 * PERIOD, -1, set()
    for index, gap in zip(order, gaps, strict=True):
        pair.receiver.accept(memoryview(packets[index]), now)
        arrived.add(index)
        for tick in range(now, now + gap):
            if pair.receiver.release(tick):
                assert pair.receiver.sequence > shown
                shown = pair.receiver.sequence
        now += gap
    for tick in range(now, now + 3 * PERIOD):
        pair.receiver.release(tick)
    assert pair.receiver.sequence == max(arrived)
    counts = pair.receiver.counts
    assert counts[Fate.ACCEPTED] + counts[Fate.REORDERED] == 12


@pytest.mark.parametrize("flags", [8, 9, 1 << 31, 2**32 - 1])
def test_a_flag_that_means_nothing_is_not_believed(pair: Pair, flags: int) -> None:
    assert pair.receiver.accept(memoryview(pair.packet(80, 0.01, flags=flags)), 81) is Fate.ABSURD
    assert not pair.receiver.stopping
    assert not pair.receiver.release(96)


@pytest.mark.parametrize("content", [-1, 81, 2**62, -(2**63)])
def test_values_of_no_time_are_not_believed(pair: Pair, content: int) -> None:
    packet = memoryview(pair.packet(80, 0.01, content=content))
    assert pair.receiver.accept(packet, 81) is Fate.ABSURD
    assert not pair.receiver.release(96)


def test_content_that_never_came_cannot_be_withheld(pair: Pair) -> None:
    withheld = memoryview(pair.packet(80, content=72, flags=PacketFlag.WITHHELD))
    assert len(withheld) < len(pair.packet(80))
    assert pair.receiver.accept(withheld, 81) is Fate.ABSURD
    assert not pair.receiver.release(96)


def test_a_packet_is_as_long_as_it_says(pair: Pair) -> None:
    writer = pair.writer
    writer._short, writer._short_plain = writer._whole, writer._plain
    assert pair.receiver.accept(memoryview(pair.packet(80, flags=4)), 81) is Fate.ABSURD


def test_a_second_copy_is_a_duplicate_and_an_ancient_one_a_replay(pair: Pair) -> None:
    first = pair.packet(0)
    pair.receiver.accept(memoryview(first), 1)
    assert pair.receiver.accept(memoryview(first), 2) is Fate.DUPLICATE
    for tick in range(1, WINDOW + 1):
        pair.receiver.accept(memoryview(pair.packet(tick * PERIOD)), tick * PERIOD)
    assert pair.receiver.accept(memoryview(first), WINDOW * PERIOD) is Fate.REPLAYED


@settings(deadline=None, max_examples=60)
@given(place=st.integers(0, 10_000), bit=st.integers(0, 7))
def test_no_flipped_bit_is_accepted(place: int, bit: int) -> None:
    pair = make_pair()
    packet = bytearray(pair.packet(80, 0.01))
    packet[place % len(packet)] ^= 1 << bit
    fate = pair.receiver.accept(memoryview(packet), 81)
    assert fate in {Fate.FORGED, Fate.FOREIGN}
    assert pair.receiver.highest(both_ends()[1].session) == -1


@settings(deadline=None, max_examples=60)
@given(size=st.integers(0, 2000))
@example(size=128)
def test_no_other_length_is_accepted(size: int) -> None:
    pair = make_pair()
    packet = pair.packet(80, 0.01)
    if size == len(packet):
        return
    cut = (packet + bytes(2000))[:size]
    # As long as one whose values are withheld, and not sealed as one.
    wrong = Fate.FORGED if size == datagram_size(3) else Fate.TRUNCATED
    assert pair.receiver.accept(memoryview(cut), 81) is wrong


@settings(deadline=None, max_examples=60)
@given(noise=st.binary(max_size=400))
def test_noise_changes_nothing(noise: bytes) -> None:
    pair = make_pair()
    assert pair.receiver.accept(memoryview(noise), 5) in {Fate.TRUNCATED, Fate.FOREIGN}
    assert not pair.receiver.release(8)


def test_another_session_is_foreign(pair: Pair) -> None:
    bundle = small_bundle()
    for a, _ in (both_ends(OTHER_KEY), both_ends(number=1)):
        writer = DataWriter(Sealer(a.outgoing, a.session), 0, bundle.size)
        writer.seal(80, 1)
        assert pair.receiver.accept(writer.datagram, 81) is Fate.FOREIGN


def test_a_foreign_key_under_our_session_number_is_forged(pair: Pair) -> None:
    mine, _ = both_ends()
    theirs, _ = both_ends(OTHER_KEY)
    writer = DataWriter(Sealer(theirs.outgoing, mine.session), 0, small_bundle().size)
    writer.seal(80, 1)
    assert pair.receiver.accept(writer.datagram, 81) is Fate.FORGED


def test_our_own_packets_sent_back_are_forged() -> None:
    """A reflection: the other direction has another key."""
    bundle = small_bundle()
    a, _ = both_ends()
    receiver = Receiver(bundle, ReceiverSettings())
    receiver.offer(Opener(a.incoming, a.session))
    writer = DataWriter(Sealer(a.outgoing, a.session), 0, bundle.size)
    writer.seal(80, 1)
    assert receiver.accept(writer.datagram, 81) is Fate.FORGED


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1.0001, -7.0])
def test_a_value_out_of_range_is_dropped(pair: Pair, value: float) -> None:
    assert pair.receiver.accept(memoryview(pair.packet(8, value)), 9) is Fate.OUT_OF_RANGE
    assert not pair.receiver.release(16)


def test_a_value_that_jumps_is_dropped_until_time_explains_it(pair: Pair) -> None:
    """3 m/s over one sample of 1/128 s is 23.4 mm."""
    pair.receiver.accept(memoryview(pair.packet(0, 0.0)), 1)
    assert pair.receiver.accept(memoryview(pair.packet(8, 0.023)), 9) is Fate.ACCEPTED
    assert pair.receiver.accept(memoryview(pair.packet(16, 0.123)), 17) is Fate.JUMP
    assert pair.receiver.accept(memoryview(pair.packet(24, 0.123)), 25) is Fate.JUMP
    assert pair.receiver.accept(memoryview(pair.packet(48, 0.123)), 49) is Fate.ACCEPTED


def test_a_packet_that_was_kept_back_is_dropped() -> None:
    pair = make_pair(ReceiverSettings(late_after=40))
    old, older = pair.packet(0), pair.packet(8)
    assert pair.receiver.accept(memoryview(old), 40) is Fate.ACCEPTED
    assert pair.receiver.accept(memoryview(older), 49) is Fate.LATE


def test_a_packet_from_the_future_is_dropped(pair: Pair) -> None:
    assert pair.receiver.accept(memoryview(pair.packet(800)), 100) is Fate.LATE


def renew(pair: Pair, number: int = 1) -> None:
    a, b = both_ends(number=number)
    pair.receiver.offer(Opener(b.incoming, b.session))
    pair.writer.renew(Sealer(a.outgoing, a.session))


def test_a_renewal_costs_nothing_that_is_on_its_way(pair: Pair) -> None:
    first, second = pair.packet(0), pair.packet(8)
    pair.receiver.accept(memoryview(first), 1)
    renew(pair)
    assert pair.receiver.accept(memoryview(second), 9) is Fate.ACCEPTED
    third = pair.packet(16)
    assert HEADER.unpack_from(third)[6] == 0
    assert pair.receiver.accept(memoryview(third), 17) is Fate.ACCEPTED
    assert pair.receiver.release(24)
    assert (pair.receiver.tick, pair.receiver.sequence) == (16, 0)


def test_what_a_later_session_has_shown_is_newer_than_all_of_the_one_before(pair: Pair) -> None:
    kept_back = pair.packet(8)
    pair.receiver.accept(memoryview(pair.packet(0)), 1)
    renew(pair)
    pair.receiver.accept(memoryview(pair.packet(16)), 17)
    pair.receiver.release(24)
    assert pair.receiver.accept(memoryview(kept_back), 25) is Fate.REORDERED


def test_a_new_session_is_no_way_around_the_jump_check(pair: Pair) -> None:
    pair.receiver.accept(memoryview(pair.packet(0, 0.0)), 1)
    for number in range(1, 6):
        renew(pair, number)
        tick = 8 * number
        assert pair.receiver.accept(memoryview(pair.packet(tick, 0.9)), tick + 1) is Fate.JUMP


def test_the_sessions_that_are_read_are_three_at_most(pair: Pair) -> None:
    old = pair.packet(0)
    for number in range(1, 4):
        renew(pair, number)
    assert pair.receiver.accept(memoryview(old), 1) is Fate.FOREIGN
    assert pair.receiver.accept(memoryview(pair.packet(0)), 1) is Fate.ACCEPTED


def test_while_a_peer_fades_nothing_new_is_shown(pair: Pair) -> None:
    pair.receiver.accept(memoryview(pair.packet(0, 0.01)), 1)
    pair.receiver.release(8)
    pair.receiver.held = True
    pair.receiver.accept(memoryview(pair.packet(8, 0.02)), 9)
    assert not pair.receiver.release(16)
    assert pair.receiver.values[0] == 0.01
    pair.receiver.held = False
    assert pair.receiver.release(17)
    assert pair.receiver.values[0] == 0.02


EXTREMES = st.sampled_from([0, -1, 1, 2**31, -(2**31), 2**53, 2**60, 2**62, 2**63 - 1, -(2**63)])
LARGEST_SEQUENCES = st.sampled_from([2**31, 2**32, 2**62, 2**63 - 1, 2**63, 2**64 - 2, 2**64 - 1])


@settings(deadline=None, max_examples=200)
@given(
    numbers=st.tuples(*[EXTREMES | st.integers(-(2**63), 2**63 - 1)] * 6), now=st.integers(0, 10**9)
)
def test_absurd_numbers_of_who_holds_the_key_are_counted(numbers, now) -> None:
    pair = make_pair()
    tick, sent, echo_sent, echo_received, epoch, acknowledged = numbers
    pair.writer.seal(
        tick,
        sent,
        echo_sent=echo_sent,
        echo_received=echo_received,
        epoch=epoch,
        acknowledged=(7, acknowledged),
    )
    fate = pair.receiver.accept(pair.writer.datagram, now)
    assert pair.receiver.counts.sum() == 1
    assert fate in {Fate.ABSURD, Fate.LATE, Fate.ACCEPTED}
    assert all(abs(time) <= 2**60 for time in pair.receiver.last_times)
    if fate is Fate.ACCEPTED:
        assert now - 256 <= tick <= now + 16


@settings(deadline=None, max_examples=50)
@given(sequence=LARGEST_SEQUENCES)
def test_absurd_sequences_of_who_holds_the_key_are_counted(sequence: int) -> None:
    pair = make_pair()
    a, _ = both_ends()
    sealer = Sealer(a.outgoing, a.session)
    sealer._next[1 << 16] = sequence
    pair.writer.renew(sealer)
    fate = pair.receiver.accept(memoryview(pair.packet(0)), 1)
    assert fate is (Fate.ABSURD if sequence >= 2**63 else Fate.ACCEPTED)
    pair.receiver.release(8)
    assert -1 <= pair.receiver.sequence < 2**63


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        (VariableType.INT32, 2.0**31),
        (VariableType.INT32, 0.5),
        (VariableType.UINT8, -1.0),
        (VariableType.UINT8, 256.0),
        (VariableType.BOOLEAN, 2.0),
        (VariableType.FLOAT32, 1e39),
        (VariableType.INT64, 2.0**60),
    ],
)
def test_an_integer_travels_within_its_type(variable: VariableType, value: float) -> None:
    """What the receiver's input cannot hold would end its run."""
    declared = Variable(name="v", type=variable, causality=Causality.OUTPUT)
    bundle = PacketBundle(
        source="a", target="b", fields=(Field.of(declared),), period=PERIOD, tick=TICK
    )
    a, b = both_ends()
    receiver = Receiver(bundle, ReceiverSettings())
    receiver.offer(Opener(b.incoming, b.session))
    writer = DataWriter(Sealer(a.outgoing, a.session), 0, 1)
    for tick, sent, fate in ((0, 1.0, Fate.ACCEPTED), (8, value, Fate.OUT_OF_RANGE)):
        writer.values[:] = sent
        writer.seal(tick, 1)
        assert receiver.accept(writer.datagram, tick + 1) is fate


def test_receiving_leaves_no_memory_behind(pair: Pair) -> None:
    def carry(ticks: range) -> None:
        for tick in ticks:
            if tick % PERIOD == 0:
                pair.writer.seal(tick, tick)
                pair.receiver.accept(pair.writer.datagram, tick)
            pair.receiver.release(tick)

    carry(range(2048))
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        carry(range(2048, 12 * 2048))
        after = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert after - before < 1024


@pytest.mark.parametrize("kind", ["forged", "replayed", "truncated", "foreign"])
def test_a_hundred_thousand_bad_packets_change_nothing(pair: Pair, kind: str) -> None:
    for tick in range(0, 4096, PERIOD):
        pair.receiver.accept(memoryview(pair.packet(tick, 0.01)), tick)
        pair.receiver.release(tick)
    pair.receiver.release(4096)
    held = (pair.receiver.tick, pair.receiver.sequence, pair.receiver.values.tobytes())
    good = pair.packet(4096, 0.02)
    bad = {"forged": bytearray(good), "truncated": bytearray(good[:-1]), "foreign": None}
    if kind == "forged":
        bad["forged"][30] ^= 1
    if kind == "foreign":
        bad["foreign"] = bytearray(make_pair(key=OTHER_KEY).packet(4096, 0.02))
    replay = make_pair()
    packets = [replay.packet(tick) for tick in range(0, 2048, PERIOD)]
    count = 100_000
    before = pair.receiver.counts.copy()
    for number in range(count):
        datagram = packets[number % len(packets)] if kind == "replayed" else bad[kind]
        pair.receiver.accept(memoryview(datagram), 4097)
    changed = pair.receiver.counts - before
    fate = {k: Fate[k.upper()] for k in ("forged", "replayed", "truncated", "foreign")}[kind]
    assert changed[fate] == count
    assert changed.sum() == count
    assert not pair.receiver.release(4104)
    assert held == (pair.receiver.tick, pair.receiver.sequence, pair.receiver.values.tobytes())
    assert pair.receiver.accept(memoryview(good), 4097) is Fate.ACCEPTED


@pytest.mark.parametrize(
    ("value", "fate"),
    [
        (math.inf, Fate.OUT_OF_RANGE),
        (-math.inf, Fate.OUT_OF_RANGE),
        (math.nan, Fate.OUT_OF_RANGE),
        (1.7e308, Fate.OUT_OF_RANGE),
        (8.0e307, Fate.ACCEPTED),
        (-8.0e307, Fate.ACCEPTED),
    ],
)
def test_a_field_without_a_range_is_finite_all_the_same(value: float, fate: Fate) -> None:
    bundle = PacketBundle(
        source="a", target="b", fields=(Field(name="v"),), period=PERIOD, tick=TICK
    )
    a, b = both_ends()
    receiver = Receiver(bundle, ReceiverSettings())
    receiver.offer(Opener(b.incoming, b.session))
    writer = DataWriter(Sealer(a.outgoing, a.session), 0, 1)
    for tick, sent in ((0, -8.0e307), (8, value)):
        writer.values[:] = sent
        writer.seal(tick, 1)
        found = receiver.accept(writer.datagram, tick + 1)
    assert found is fate
