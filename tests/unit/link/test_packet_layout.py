"""The packet of docs/protocol.md, byte for byte, written and read here with struct alone."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.link.stream.bundle import Field, PacketBundle
from cosim.link.wire.packet import DataReader, DataWriter, Opener, Sealer, datagram_size
from tests.support.link.support import KEY, PERIOD, TICK, both_ends, small_bundle

PROTOCOL = Path(__file__).parents[3] / "docs" / "protocol.md"


KEY_BYTES = bytes(range(100, 132))
SESSION = 0xFF3D3F101BDC35B0
"""Of the document's example: what a handshake has come to."""


def example_datagram() -> bytes:
    bundle = small_bundle()
    writer = DataWriter(Sealer(KEY_BYTES, SESSION), 0, bundle.size)
    for _ in range(3):
        writer.seal(0, 0)
    writer.values[:] = [0.125, -0.25, 0.5, 0.0, 1024, 1, 11]
    writer.seal(
        1024,
        1_000_000_000,
        echo_sent=998_000_000,
        echo_received=999_000_000,
        epoch=500,
        acknowledged=(0x1_00C0_FFEE, 41),
    )
    return bytes(writer.datagram)


def test_worked_example_of_the_document_is_what_the_code_sends() -> None:
    text = PROTOCOL.read_text(encoding="utf-8")
    block = re.search(r"```hex\n(.*?)```", text, re.DOTALL)
    assert block is not None
    lines = (line.split("|")[0] for line in block[1].splitlines())
    assert bytes.fromhex(" ".join(lines)) == example_datagram()


def test_another_program_can_read_the_example() -> None:
    datagram = example_datagram()
    header, sealed = datagram[:24], datagram[24:]
    assert struct.unpack("<2sBBHHQQ", header) == (b"cH", 2, 1, 0, 0, SESSION, 3)
    body = AESGCM(KEY_BYTES).decrypt(struct.pack("<BBHQ", 1, 0, 0, 3), sealed, header)
    assert struct.unpack_from("<qqqqqqIIq", body) == (
        1024,
        1_000_000_000,
        998_000_000,
        999_000_000,
        500,
        41,
        0,
        0xC0FFEE,
        1024,
    )
    assert struct.unpack("<7d", body[64:]) == (0.125, -0.25, 0.5, 0.0, 1024.0, 1.0, 11.0)
    assert len(datagram) == datagram_size(7) == 24 + 64 + 7 * 8 + 16


@settings(deadline=None, max_examples=50)
@given(
    values=st.lists(st.floats(width=64), min_size=1, max_size=40),
    tick=st.integers(0, 2**62),
    times=st.tuples(*[st.integers(0, 2**62)] * 3),
    acknowledged=st.integers(-1, 2**62),
)
def test_every_value_and_time_survives_the_way(values, tick, times, acknowledged) -> None:
    a, b = both_ends()
    writer = DataWriter(Sealer(a.outgoing, a.session), 3, len(values))
    reader = DataReader(Opener(b.incoming, b.session), 3, len(values))
    writer.values[:] = values
    sent, echo_sent, echo_received = times
    writer.seal(
        tick, sent, echo_sent=echo_sent, echo_received=echo_received, acknowledged=(7, acknowledged)
    )
    opened = reader.open(writer.datagram, 0)
    assert opened == (tick, sent, echo_sent, echo_received, 0, acknowledged, 0, 7, tick)
    assert reader.values.tobytes() == writer.values.tobytes()


def test_the_two_directions_have_different_keys() -> None:
    a, b = both_ends()
    assert a.outgoing == b.incoming
    assert a.incoming == b.outgoing
    assert a.outgoing != a.incoming
    assert a.session == b.session


def test_a_bundle_that_needs_two_datagrams_is_refused() -> None:
    fields = tuple(Field(name=f"v{i}", size=10) for i in range(20))
    with pytest.raises(InputError, match=r"carries 200 numbers and needs 1704 bytes.*1232"):
        PacketBundle(source="a", target="b", fields=fields, period=PERIOD, tick=TICK)


def test_a_variable_is_sent_once() -> None:
    with pytest.raises(InputError, match="carries v twice"):
        PacketBundle(
            source="a",
            target="b",
            fields=(Field(name="v"), Field(name="v")),
            period=PERIOD,
            tick=TICK,
        )


def test_pre_shared_key_and_session_keys_never_show_their_bytes() -> None:
    a, _ = both_ends()
    assert "0001" not in repr(KEY)
    assert a.outgoing.hex() not in repr(a)
    assert repr(a.outgoing) not in repr(a)
