"""What a radio that slept hands over at once is read newest first, and the newest one counts."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.link.stream.intake import Intake
from cosim.link.stream.receiver import ReceiverSettings
from tests.support.link.support import PERIOD, TICK, Pair, make_pair

RATE = 128
"""Packets a second; half a second of them is less than the replay window."""


class Queue:
    """A transport in which datagrams wait, in the order in which they came."""

    def __init__(self, datagrams: list[bytes]) -> None:
        self.waiting = list(datagrams)

    def receive(self, buffer: memoryview) -> int:
        if not self.waiting:
            return -1
        datagram = self.waiting.pop(0)
        buffer[: len(datagram)] = datagram
        return len(datagram)

    def arrival(self) -> int:
        return 0


def burst(pair: Pair, count: int) -> list[bytes]:
    """Packets of a peer whose grid moved with each of them."""
    return [pair.packet(tick * PERIOD, epoch=1000 + tick) for tick in range(count)]


@given(st.permutations(range(40)))
def test_it_is_read_newest_first(order: list[int]) -> None:
    packets = burst(make_pair(), len(order))
    intake = Intake(Queue([packets[number] for number in order]), rate=Fraction(RATE), tick=TICK)
    values, full = intake.read(0, lambda _: pytest.fail("these are values"))
    assert [sequence for sequence, *_ in values] == sorted(range(len(order)), reverse=True)
    assert not full
    for sequence, place, size, _ in values:
        assert bytes(intake.buffers[place][:size]) == packets[sequence]


@given(st.permutations(range(12)))
def test_where_the_peers_grid_is_the_newest_one_says(order: list[int]) -> None:
    pair = make_pair()
    packets = burst(pair, len(order))
    for number in order:
        pair.receiver.accept(memoryview(packets[number]), 12 * PERIOD)
    assert pair.receiver.peer_epoch == 1011


@pytest.mark.parametrize("delay", [1, 8, 16, 17, 40, 100])
def test_a_packet_waits_as_long_as_it_is_told_to_however_many_wait_with_it(delay: int) -> None:
    pair = make_pair(ReceiverSettings(delay=delay))
    shown: list[int] = []
    for sample in range(3 * delay + 4):
        pair.receiver.accept(memoryview(pair.packet(sample * PERIOD)), sample * PERIOD + 1)
        if pair.receiver.release((sample + 1) * PERIOD):
            shown.append(pair.receiver.tick // PERIOD)
            assert pair.receiver.delay == delay * PERIOD
    assert shown == list(range(2 * delay + 5))
