"""What a user did wrong is said in a sentence, before anything runs where it can be known."""

from __future__ import annotations

import json
import select
import socket
import struct
import sys
import time
from fractions import Fraction

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli.netchar import command as netchar
from cosim.cli.station import command as station
from cosim.link.session.answerer import Answerer
from cosim.link.session.asker import Asker
from cosim.link.session.client import HandshakeProcess
from cosim.link.session.contract import Contract
from cosim.link.session.keys import KEY_SIZE, NO_KEY, PreSharedKey, create_key_file
from cosim.link.session.messages import LARGEST_MESSAGE, NOTE, refusal
from cosim.link.session.process import HandshakeServer
from cosim.link.stream.remote import Grid
from cosim.link.wire.address import Address
from cosim.link.wire.packet import HEADER, MAGIC, VERSION, PacketKind
from cosim.link.wire.sockets import open_socket, open_sockets
from cosim.station.facts import link_facts

LOCAL = Address("127.0.0.1", 0)
STATION = ["two_users_box", "--as", "station_a", "--wait", "1", "--no-figure"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "give the address of station_b with --peer station_b=host:port"),
        (("--peer", "127.0.0.1"), "--peer is host:port, for example 127.0.0.1:47000"),
        (("--peer", "127.0.0.1:99999"), "a port is a number up to 65535"),
        (("--peer", "nosuchhost.invalid:47000"), "the host nosuchhost.invalid cannot be found"),
        (("--peer", "192.0.2.1:47000"), "there is no key: anybody could push on the user's hand"),
        (("--peer", "127.0.0.1:47001", "--key", "absent"), "absent cannot be read: No such file"),
        (("--peer", "127.0.0.1:47001", "--key", "junk"), "is not a key; make one with"),
        (("--peer", "127.0.0.1:47001", "--key", "open"), "can be read or written by others"),
        (("--peer", "127.0.0.1:47001", "--key", "."), "cannot be read: Is a directory"),
        (("--peer", "127.0.0.1:47000"), "is this station's own address and the peer's"),
        (("--listen", "[::1]:1", "--peer", "127.0.0.1:47000"), "two kinds, IPv4 and IPv6"),
        (("--listen", "192.0.2.9:1", "--peer", "192.0.2.8:1", "--key", "key"), "cannot listen on"),
    ],
)
def test_a_station_refuses_what_cannot_be(tmp_path, monkeypatch, options, message) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("signal.signal", lambda *_: None)
    for name in ("key", "open"):
        create_key_file(tmp_path / name)
    (tmp_path / "open").chmod(0o644)
    (tmp_path / "junk").write_text("junk")
    (tmp_path / "junk").chmod(0o600)
    result = CliRunner().invoke(station, [*STATION, *options])
    assert isinstance(result.exception, InputError), result.output
    assert message in str(result.exception)
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--rate", "0"), "'--rate': 0.0 is not in the range"),
        (("--rate", "nan"), "'--rate': nan is not a finite number"),
        (("--size", "9"), "a packet of 9 bytes cannot be sent"),
        (("--duration", "0"), "'--duration': 0.0 is not in the range"),
    ],
)
def test_a_probe_refuses_before_it_looks_for_a_relay(monkeypatch, options, message) -> None:
    monkeypatch.setattr("signal.signal", lambda *_: None)
    result = CliRunner().invoke(netchar, ["probe", "127.0.0.1:9", *options])
    assert message in f"{result.output}{result.exception}"
    assert "relay" not in result.output


def test_a_port_in_use_is_said_with_its_address() -> None:
    with open_socket(LOCAL, None) as taken:
        address = Address(*taken.getsockname())
        with pytest.raises(InputError, match=f"cannot listen on {address}: Address already in use"):
            open_socket(address, None)


def test_a_name_of_both_kinds_is_taken_in_the_kind_of_the_other_end(monkeypatch) -> None:
    both = [
        (socket.AF_INET6, socket.SOCK_DGRAM, 17, "", ("::1", 5, 0, 0)),
        (socket.AF_INET, socket.SOCK_DGRAM, 17, "", ("127.0.0.1", 5)),
    ]
    real = socket.getaddrinfo
    monkeypatch.setattr(
        socket,
        "getaddrinfo",
        lambda host, *rest, **more: both if host == "both" else real(host, *rest, **more),
    )
    with open_socket(LOCAL, Address("both", 5)) as link:
        assert link.getpeername() == ("127.0.0.1", 5)
    assert Address("both", 5).is_loopback


class Waiting:
    """The handshake process of station a, in this one, and a socket where b should be."""

    def __init__(self) -> None:
        self.peer = open_socket(LOCAL, None)
        own = open_socket(LOCAL, Address(*self.peer.getsockname()))
        self.peer.connect(own.getsockname())
        self.loop, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.process = HandshakeServer(
            {
                "own": "a",
                "peers": ["b"],
                "sockets": [own.detach()],
                "loop": theirs.detach(),
                "key_files": [None],
                "contracts": [{"rate": 128}],
                "tick": "1/1024",
                "period": 8,
            }
        )

    def notes_after(self, *datagrams: bytes) -> list[str]:
        for datagram in datagrams:
            self.process.take(0, datagram, 1)
        notes = self.process.notes()
        assert all(note[:1] == NOTE for note in notes)
        return [note[1:].decode() for note in notes]

    def __enter__(self) -> Waiting:
        return self

    def __exit__(self, *_) -> None:
        for one in (self.peer, self.loop, self.process.loop, self.process.links[0].socket):
            one.close()


def hello(own: str, peer: str, key: PreSharedKey = NO_KEY) -> bytes:
    return Asker(own=own, peer=peer, key=key, contract=Contract({"rate": 128})).poll(0)[0]


def test_another_key_is_said_once_to_who_waits() -> None:
    other = hello("b", "a", PreSharedKey(bytes(range(KEY_SIZE))))
    with Waiting() as waiting:
        assert waiting.notes_after(other) == []
        (note,) = waiting.notes_after(*[other] * 10)
        assert "the address of b (b) does not fit the key" in note
        assert waiting.notes_after(other) == []


def test_another_version_of_the_protocol_is_said_once_whoever_writes_which() -> None:
    headers = [
        HEADER.pack(MAGIC, version, PacketKind.HELLO, 0, 0, 0, 0) for version in (1, 3, 4, 255)
    ]
    with Waiting() as waiting:
        notes = waiting.notes_after(*[header + bytes(1176) for header in headers] * 10)
    assert notes == [
        (
            f"b speaks version 1 of the link's protocol, and this station version {VERSION}: run "
            "one version of cohaptic on both"
        )
    ]


def test_an_address_where_nobody_listens_is_said() -> None:
    with Waiting() as waiting:
        waiting.peer.close()
        waiting.process.links[0].refused = 21
        (note,) = waiting.notes_after()
    assert note.startswith("nothing at the address of b (b) takes packets of this station")


def test_two_stations_of_one_name_are_said() -> None:
    """Each end sees what it would send itself: a greeting, or the word of who waits to be asked."""
    mine = Answerer(own="a", peer="b", key=NO_KEY, contract=Contract({"rate": 128}))
    with Waiting() as waiting:
        (note,) = waiting.notes_after(*mine.poll(0) * 3)
    assert note.startswith("the station at the address of b (b) is called a, too")


def test_noise_and_a_good_greeting_are_not_worth_a_word() -> None:
    with Waiting() as waiting:
        assert waiting.notes_after(b"", bytes(30), struct.pack("<Q", 7), hello("b", "a")) == []


def test_every_datagram_that_changes_nothing_is_in_the_manifest() -> None:
    other_key = hello("b", "a", PreSharedKey(bytes(range(KEY_SIZE))))
    old = HEADER.pack(MAGIC, 1, PacketKind.HELLO, 0, 0, 0, 0) + bytes(1176)
    value = HEADER.pack(MAGIC, VERSION, PacketKind.DATA, 0, 0, 5, 0) + bytes(100)
    own = Answerer(own="a", peer="b", key=NO_KEY, contract=Contract({"rate": 128})).poll(0)
    with Waiting() as waiting:
        waiting.notes_after(b"", bytes(23), *[value] * 3, *[old] * 4, *[other_key] * 5, *own)
        facts = waiting.process.facts()
    assert facts == {
        "absurd_grids": 0,
        "short": 2,
        "early_values": 3,
        "other_versions": 4,
        "b": {
            "foreign": 6,
            "stray": 0,
            "too_many": 0,
            "same_name": 1,
            "absurd_exchanges": 0,
            "refused": 0,
            "unsent": 0,
        },
    }


def test_a_refusal_is_cut_by_sentences_and_not_by_bytes() -> None:
    """Contracts may differ in thousands of names, and names may be long."""
    lines = [f"{'ä' * 400}[{number}]: 1 at a, 2 at b" for number in range(3000)]
    message = refusal("b", lines)
    assert len(message) < LARGEST_MESSAGE
    facts = json.loads(message[1:])
    shown = len(facts["differences"]) - 1
    assert facts["differences"] == [*lines[:shown], f"and {3000 - shown} more"]
    assert shown >= 5


@pytest.mark.parametrize(
    "message",
    [
        b"R{",
        b"Rnull",
        b"R[]",
        b'R{"peer": 3}',
        b"O",
        b"U" + bytes(40),
        b"K\xff",
        b"A\x09" + bytes(16),
        b"G",
        b"F{",
        b"",
        b"\xff" * 9000,
        refusal("b", ["x"] * 50),
        b'R{"error": "the key is gone"}',
    ],
)
def test_nothing_that_the_process_says_ends_a_running_loop(message: bytes) -> None:
    process = HandshakeProcess("b", ["a"])
    mine, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with mine, theirs:
        process.attach(mine)
        if message:
            theirs.send(message)
        else:
            theirs.close()
        process.hear()
    assert process.start is None


def test_a_process_that_is_gone_has_no_counts_and_is_not_waited_for() -> None:
    process = HandshakeProcess("b", ["a"])
    mine, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with mine:
        process.attach(mine)
        theirs.close()
        before = time.monotonic()
        process.leave()
    assert time.monotonic() - before < 1.0
    facts = link_facts("b", Grid(tick_ns=1e6), [], [], process)
    assert facts["handshake_process"] == {"dropped": 0, "absurd": 0, "answered": False}


def test_a_message_of_no_known_kind_is_counted() -> None:
    process = HandshakeProcess("b", ["a"])
    mine, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with mine, theirs:
        process.attach(mine)
        for message in (b"K\xff", b"Gx", b"\0"):
            theirs.send(message)
        process.hear()
    assert process.absurd == 3


def test_what_cannot_be_a_greeting_uses_up_no_room_of_one() -> None:
    """Between two looks at the process the loop hands on so many; junk is looked at before."""
    process = HandshakeProcess("b", ["a"])
    mine, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    theirs.setblocking(False)
    greeting = hello("b", "a")
    with mine, theirs:
        process.attach(mine)
        pass_on = process.forward(0)
        for number in range(10_000):
            junk = HEADER.pack(MAGIC, VERSION, 16 + number % 6, 0, 0, number, 0) + bytes(57)
            pass_on(memoryview(junk), 1)
        pass_on(memoryview(greeting), 1)
        assert theirs.recv(2000).endswith(greeting)
        assert process.dropped == 10_000


def test_the_process_that_holds_the_key_imports_nothing_of_the_working_folder(
    tmp_path, monkeypatch
) -> None:
    """A file ``secrets.py`` and a folder ``cosim`` there, and on the path of the environment."""
    trap = "import pathlib; pathlib.Path(__file__).with_suffix('.sprung').touch()\n"
    (tmp_path / "secrets.py").write_text(trap)
    (tmp_path / "cosim").mkdir()
    (tmp_path / "cosim" / "__init__.py").write_text(trap)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    peer = open_socket(LOCAL, None)
    own = open_socket(LOCAL, Address(*peer.getsockname()))
    process = HandshakeProcess("b", ["a"])
    with peer, own, process:
        process.open(
            sockets=[own],
            key_files=[None],
            contracts=[{}],
            addresses=["here"],
            tick=Fraction(1, 1024),
            period=8,
            exchanges=16,
        )
        peer.setblocking(True)
        peer.settimeout(20)
        assert peer.recv(2000)[3] == PacketKind.HELLO
    assert not list(tmp_path.rglob("*.sprung"))


def test_a_copy_of_a_station_cannot_take_over_its_port() -> None:
    """Three stations share one port at each, and nobody else may have it."""
    peers = [open_socket(LOCAL, None) for _ in range(2)]
    addresses = [Address(*peer.getsockname()) for peer in peers]
    with open_socket(LOCAL, None) as free:
        listen = Address(*free.getsockname())
    links = open_sockets(listen, addresses)
    try:
        for again in (lambda: open_sockets(listen, addresses), lambda: open_socket(listen, None)):
            with pytest.raises(InputError, match="does this station run already"):
                again()
        for peer, link in zip(peers, links, strict=True):
            peer.sendto(b"to you", listen.resolve()[1])
            select.select([link], [], [], 5.0)
            assert link.recv(100) == b"to you"
    finally:
        for link in (*links, *peers):
            link.close()


@pytest.mark.skipif(sys.platform != "linux", reason="read back as Linux gives them")
@pytest.mark.parametrize("host", ["127.0.0.1", "::1"])
def test_packets_ask_for_expedited_forwarding_and_the_highest_free_priority(host: str) -> None:
    with open_socket(Address(host, 0), None) as link:
        assert link.getsockopt(socket.SOL_SOCKET, socket.SO_PRIORITY) == 6
        if link.family is socket.AF_INET6:
            assert link.getsockopt(socket.IPPROTO_IPV6, socket.IPV6_TCLASS) == 0xB8
        else:
            assert link.getsockopt(socket.IPPROTO_IP, socket.IP_TOS) == 0xB8
