"""What the kernel lets into a link's socket, asked of the kernel itself."""

from __future__ import annotations

import socket
import sys
import time

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cosim.link.wire.address import Address
from cosim.link.wire.kernel_filter import attach, dropped, session_filter
from cosim.link.wire.packet import HEADER, LARGEST_DATAGRAM, MAGIC, VERSION, PacketKind
from cosim.link.wire.sockets import open_socket

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="a classic BPF filter is Linux's")

LOCAL = Address("127.0.0.1", 0)
numbers = st.integers(0, 2**32 - 1) | st.integers(0, 600)


@pytest.fixture(name="ends", scope="module")
def _ends():
    receiver = open_socket(LOCAL, None)
    sender = open_socket(LOCAL, Address(*receiver.getsockname()))
    with receiver, sender:
        yield sender, receiver


def let_in(ends: tuple[socket.socket, socket.socket], *datagrams: bytes) -> int:
    """How many of them come out of the socket; the kernel counts all the others as dropped."""
    sender, receiver = ends
    before, arrived = dropped(receiver), 0
    for datagram in datagrams:
        sender.send(datagram)
    end = time.monotonic() + 30.0
    while arrived + dropped(receiver) - before < len(datagrams):
        assert time.monotonic() < end, "a datagram is neither there nor counted"
        try:
            receiver.recv(1 << 16)
            arrived += 1
        except BlockingIOError:
            time.sleep(0.0)
    return arrived


@pytest.mark.parametrize("size", [0, 1, 24, LARGEST_DATAGRAM, LARGEST_DATAGRAM + 1, 9000, 60_000])
def test_nothing_longer_than_a_datagram_of_the_link_takes_room(ends, size: int) -> None:
    assert let_in(ends, bytes(size)) == (size <= LARGEST_DATAGRAM)


@settings(deadline=None, max_examples=300)
@given(
    kind=st.sampled_from([*PacketKind, 0, 2, 15, 22]),
    sequences=st.tuples(numbers, numbers),
    flip=st.none() | st.integers(0, 63),
    session=st.integers(0, 2**64 - 1),
    handshakes=st.booleans(),
)
@example(kind=1, sequences=(255, 256), flip=None, session=1, handshakes=False)
@example(kind=1, sequences=(2**32 - 1, 2**32 - 1), flip=None, session=1, handshakes=False)
def test_in_a_flood_only_the_sessions_next_packets_get_in(
    ends, *, kind: int, sequences: tuple[int, int], flip: int | None, session: int, handshakes: bool
) -> None:
    sequence, floor = sequences
    assert attach(ends[1], session_filter(session, floor, handshakes=handshakes))
    other = session if flip is None else session ^ (1 << flip)
    header = HEADER.pack(MAGIC, VERSION, kind, 3, 0, other, sequence)
    next_one = kind == PacketKind.DATA and flip is None and sequence >= floor
    shakes = handshakes and PacketKind.HELLO <= kind <= PacketKind.KEEP
    assert let_in(ends, header + bytes(100)) == (next_one or shakes)


def test_another_protocol_stays_out_in_a_flood(ends) -> None:
    assert attach(ends[1], session_filter(7, 0, handshakes=True))
    good = HEADER.pack(MAGIC, VERSION, PacketKind.DATA, 0, 0, 7, 0)
    for place in range(3):
        changed = bytearray(good)
        changed[place] ^= 1
        assert let_in(ends, changed) == 0
    assert let_in(ends, good[:-1], good) == 1
