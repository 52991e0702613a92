"""CANopen frames: the published bytes, what the ``canopen`` package reads, and nothing else."""

from __future__ import annotations

import struct

import canopen
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.device.errors import ProtocolError
from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.emulated_objects import dictionary
from hil.drivers.canopen.protocol import Index, NmtCommand, NmtState, Object

nodes = st.integers(1, 127)
anything = st.binary(max_size=8)


@given(nodes)
def test_identifiers_are_the_predefined_connection_set(node):
    assert (wire.NMT, wire.SYNC) == (0x000, 0x080)
    functions = {
        wire.emergency_id: 0x080,
        wire.positions_id: 0x180,
        wire.outputs_id: 0x200,
        wire.sdo_answer_id: 0x580,
        wire.sdo_request_id: 0x600,
        wire.heartbeat_id: 0x700,
    }
    assert [name(node) - base for name, base in functions.items()] == [node] * len(functions)
    assert len({name(node) for name in functions}) == len(functions)


def test_published_bytes():
    """CiA 301: NMT, heartbeat, SDO; the mapping entries of CiA 406 and CiA 401."""
    assert wire.nmt(NmtCommand.START, 5) == bytes((1, 5))
    assert wire.nmt(NmtCommand.RESET_COMMUNICATION, 0) == bytes((130, 0))
    assert wire.heartbeat(NmtState.OPERATIONAL) == b"\x05"
    assert wire.mapping(Index.POSITION, 0, 32) == 0x60040020
    assert wire.mapping(Index.OUTPUT, 1, 16) == 0x64110110
    assert wire.consumer(127, 20) == 0x007F0014
    assert wire.sdo_upload(Object(0x1018, 4, 4)) == bytes.fromhex("4018100400000000")
    assert wire.sdo_download(Object(0x6443, 1, 1), 1) == bytes.fromhex("2f43640101000000")
    assert wire.sdo_download(Object(0x6411, 2, 2), -2) == bytes.fromhex("2b116402feff0000")
    assert wire.outputs((1, -1)) == bytes.fromhex("0100ffff")
    assert wire.positions(bytes.fromhex("01000000ffffffff"), 2) == (1, -1)


class Wire(canopen.Network):
    """Between our requests and the package's SDO server."""

    def __init__(self):
        super().__init__()
        self.answers = []

    def send_message(self, can_id, data, remote=False):
        assert can_id == wire.sdo_answer_id(1)
        self.answers.append(bytes(data))

    def ask(self, request):
        self.answers.clear()
        self.notify(wire.sdo_request_id(1), bytearray(request), 0.0)
        (answer,) = self.answers
        return wire.sdo_answer(answer)


@pytest.fixture(scope="module")
def server():
    made = Wire()
    made.create_node(1, dictionary(1))
    return made


WRITABLE = (
    Object(0x1016, 1, 4),
    Object(0x6443, 1, 1),
    Object(0x6411, 2, 2),
    Object(0x6444, 2, 4),
)


@settings(deadline=None)
@given(st.sampled_from(WRITABLE), st.integers(-(2**31), 2**32 - 1))
def test_the_packages_sdo_server_takes_and_gives_back_what_is_written(server, entry, value):
    written = server.ask(wire.sdo_download(entry, value))
    assert (written.abort, written.value) == (0, None)
    kept = server[1].get_data(entry.index, entry.subindex)
    assert kept == (value & (1 << 8 * entry.size) - 1).to_bytes(entry.size, "little")
    read = server.ask(wire.sdo_upload(entry))
    assert read.is_for(entry)
    assert struct.pack("<I", read.value)[: entry.size] == kept


NAME = 0x1008
"""The node's name: longer than one answer, and nobody asks for it."""


@settings(deadline=None)
@given(st.integers(0, 0xFFFF).filter(lambda index: index != NAME), st.integers(0, 255))
def test_a_refusal_of_the_server_is_a_refusal_here(server, index, subindex):
    answer = server.ask(wire.sdo_upload(Object(index, subindex, 4)))
    known = index in server[1].object_dictionary
    assert answer.abort == 0 or answer.value is None
    if not known:
        assert answer.abort == 0x06020000


@settings(deadline=None)
@given(anything)
def test_noise_is_refused_or_is_exactly_a_frame(data):
    for parse in (wire.state, wire.emergency, wire.sdo_answer, lambda d: wire.positions(d, 2)):
        try:
            found = parse(data)
        except ProtocolError:
            continue
        assert len(data) == (1 if isinstance(found, NmtState) else 8)
        match found:
            case NmtState():
                assert wire.heartbeat(found) == data
            case wire.Emergency():
                assert struct.pack("<HB", found.code, found.register) + found.vendor == data
            case wire.SdoAnswer():
                assert struct.pack("<HB", found.index, found.subindex) == data[1:4]
                assert data[0] in {0x42, 0x43, 0x47, 0x4B, 0x4F, 0x60, 0x80}
            case _:
                assert struct.pack("<2i", *found) == data


@given(st.integers(0, 0xFFFF), st.integers(0, 255), st.binary(min_size=5, max_size=5))
def test_an_emergency_says_its_code(code, register, vendor):
    report = wire.emergency(struct.pack("<HB", code, register) + vendor)
    assert (report.code, report.register, report.vendor) == (code, register, vendor)
    assert f"0x{code:04x}" in str(report)
    assert f"0x{register:02x}" in str(report)


spans = st.sampled_from([20_000, 1 << 16, 20_000 * 4096, 1 << 32])


@settings(deadline=None)
@given(spans, st.integers(-(2**31), 2**31 - 1), st.lists(st.integers(-9_999, 9_999), max_size=30))
def test_a_position_is_followed_over_the_end_of_its_range(span, start, moves):
    true, shown, followed = start, start % span, start
    for move in moves:
        true += move
        wrapped = true % span
        signed = wrapped - 2**32 if wrapped >= 2**31 else wrapped
        followed += wire.step(shown, signed, span)
        shown = signed
    assert followed == true
