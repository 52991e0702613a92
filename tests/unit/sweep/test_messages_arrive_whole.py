"""However a socket cuts a stream of messages, each arrives once, whole and in its order."""

from __future__ import annotations

import socket
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.sweep.work.message_socket import MessageSocket


@settings(max_examples=50, deadline=None)
@given(
    messages=st.lists(st.binary(max_size=300), max_size=20),
    cuts=st.lists(st.integers(0, 8000), max_size=20),
)
def test_however_they_are_cut(messages: list[bytes], cuts: list[int]) -> None:
    sent, taken = socket.socketpair()
    with sent, taken:
        pipe = MessageSocket(sent)
        for message in messages:
            pipe.send(message)
        stream = taken.recv(1 << 20) if messages else b""
    raw, end = socket.socketpair()
    with raw:
        reader = MessageSocket(end)
        found: list[bytes] = []
        places = sorted({0, len(stream), *(min(cut, len(stream)) for cut in cuts)})
        for first, last in pairwise(places):
            raw.sendall(stream[first:last])
            found += reader.receive()
        assert found == messages
        reader.close()


def test_what_came_before_the_end_is_had_before_the_end_is_told() -> None:
    ours, theirs = socket.socketpair()
    left, right = MessageSocket(ours), MessageSocket(theirs)
    left.send(b"the last result")
    left.close()
    assert right.receive() == [b"the last result"]
    with pytest.raises(EOFError):
        right.receive()
    right.close()
