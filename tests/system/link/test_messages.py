"""What a user did wrong is said in a sentence, before anything runs where it can be known."""

from __future__ import annotations

import socket
import struct

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli.netchar import command as netchar
from cosim.cli.station import command as station
from cosim.link.session.doorman import NOTE, _Process
from cosim.link.session.handshake import Handshake
from cosim.link.session.keys import KEY_SIZE, PreSharedKey, create_key_file
from cosim.link.wire.packet import HEADER, MAGIC, VERSION, Kind
from cosim.link.wire.transport import Address, open_socket

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
        (("--rate", "0"), "a rate of 0 packets a second cannot be sent"),
        (("--size", "9"), "a packet of 9 bytes cannot be sent"),
        (("--duration", "0"), "a measurement of 0 s cannot be made"),
    ],
)
def test_a_probe_refuses_before_it_looks_for_a_relay(monkeypatch, options, message) -> None:
    monkeypatch.setattr("signal.signal", lambda *_: None)
    result = CliRunner().invoke(netchar, ["probe", "127.0.0.1:9", *options])
    assert isinstance(result.exception, InputError)
    assert message in str(result.exception)


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


class Door:
    """The process at the door of station a, in this one, and a socket where b should be."""

    def __init__(self) -> None:
        self.peer = open_socket(LOCAL, None)
        own = open_socket(LOCAL, Address(*self.peer.getsockname()))
        self.peer.connect(own.getsockname())
        self.loop, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.process = _Process(
            {
                "own": "a",
                "peers": ["b"],
                "sockets": [own.detach()],
                "loop": theirs.detach(),
                "key_file": None,
                "contracts": [{"rate": 128}],
                "tick": "1/1024",
                "period": 8,
            }
        )

    def notes_after(self, *datagrams: bytes) -> list[str]:
        for datagram in datagrams:
            self.process._pass(0, datagram, 1)
        notes = self.process._notes()
        assert all(note[:1] == NOTE for note in notes)
        return [note[1:].decode() for note in notes]

    def __enter__(self) -> Door:
        return self

    def __exit__(self, *_) -> None:
        for one in (self.peer, self.loop, self.process.loop, self.process.links[0].socket):
            one.close()


def test_another_key_is_said_once_to_who_waits() -> None:
    theirs = PreSharedKey(bytes(range(KEY_SIZE)))
    other = Handshake(own="b", peer="a", key=theirs, contract=_contract())
    hello = other.poll(0)
    assert hello is not None
    with Door() as door:
        assert door.notes_after(hello) == []
        (note,) = door.notes_after(*[hello] * 10)
        assert "the address of b does not fit the key" in note
        assert door.notes_after(hello) == []


def test_another_version_of_the_protocol_is_said() -> None:
    header = HEADER.pack(MAGIC, VERSION + 1, Kind.HELLO, 0, 0, 0, 0)
    with Door() as door:
        notes = door.notes_after(*[header + bytes(1176)] * 10)
    assert notes == [
        (
            f"b speaks version {VERSION + 1} of the link's protocol, and this station version "
            f"{VERSION}: run one version of cohaptic on both"
        )
    ]


def test_an_address_where_nobody_listens_is_said() -> None:
    with Door() as door:
        door.peer.close()
        door.process.links[0].refused = 21
        (note,) = door.notes_after()
    assert note == "nothing listens at the address of b so far"


def test_noise_and_a_good_greeting_are_not_worth_a_word() -> None:
    from cosim.link.session.keys import NO_KEY

    good = Handshake(own="b", peer="a", key=NO_KEY, contract=_contract()).poll(0)
    assert good is not None
    with Door() as door:
        assert door.notes_after(b"", bytes(30), struct.pack("<Q", 7), good) == []


def _contract():
    from cosim.link.session.contract import Contract

    return Contract({"rate": 128})
