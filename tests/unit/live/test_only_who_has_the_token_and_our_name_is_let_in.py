"""Exact lists of hosts and origins, GET alone, a token in the socket's subprotocol."""

from __future__ import annotations

from http import HTTPStatus

import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.datastructures import Headers

from cosim.base.errors import InputError
from cosim.live.access import SOCKET, Access, hosts_of, listening

ACCESS = Access(hosts=hosts_of("127.0.0.1", 8500), token="a-token")
OURS = {
    "Host": "localhost:8500",
    "Origin": "http://localhost:8500",
    "Sec-WebSocket-Protocol": "cohaptic, a-token",
}


def status(method: str = "GET", path: str = SOCKET, **changed: str | None) -> HTTPStatus | None:
    given_ = {**OURS, **{name.replace("_", "-"): value for name, value in changed.items()}}
    headers = Headers({name: value for name, value in given_.items() if value is not None})
    refusal = ACCESS.refusal(method, path, headers)
    return None if refusal is None else refusal.status


def test_our_own_page_is_let_in() -> None:
    assert status() is None
    assert status(Host="127.0.0.1:8500", Origin="http://127.0.0.1:8500") is None
    assert status(path="/", Origin=None, Sec_WebSocket_Protocol=None) is None


@pytest.mark.parametrize("path", ["/", SOCKET])
@pytest.mark.parametrize("method", ["POST", "HEAD", "PUT", "OPTIONS", "get"])
def test_only_get_is_answered(method: str, path: str) -> None:
    assert status(method, path) is HTTPStatus.METHOD_NOT_ALLOWED


@pytest.mark.parametrize("path", ["/", SOCKET])
@pytest.mark.parametrize(
    "host", ["evil.example:8500", "localhost", "localhost:8501", "localhost:8500.", "", None]
)
def test_a_page_led_here_by_another_name_is_refused(host: str | None, path: str) -> None:
    assert status(path=path, Host=host) is HTTPStatus.FORBIDDEN
    rebound = None if host is None else f"http://{host}"
    assert status(path=path, Host=host, Origin=rebound) is HTTPStatus.FORBIDDEN


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "https://localhost:8500", "http://localhost:8501", "null"]
)
def test_a_foreign_origin_is_refused(origin: str) -> None:
    assert status(Origin=origin) is HTTPStatus.FORBIDDEN
    assert status(path="/", Origin=origin) is HTTPStatus.FORBIDDEN


def test_the_socket_needs_an_origin() -> None:
    assert status(Origin=None) is HTTPStatus.FORBIDDEN


def test_a_header_that_comes_twice_is_refused() -> None:
    for name in ("Host", "Origin"):
        headers = Headers(OURS)
        headers[name] = OURS[name]
        refusal = ACCESS.refusal("GET", SOCKET, headers)
        assert refusal is not None
        assert refusal.status is HTTPStatus.FORBIDDEN


@given(st.text(st.characters(codec="latin-1", exclude_categories=["Cc"]), max_size=40))
def test_anything_but_the_token_is_refused(offered: str) -> None:
    known = [part.strip() for part in offered.split(",")] == ["cohaptic", "a-token"]
    assert (status(Sec_WebSocket_Protocol=offered) is None) == known
    assert status(Sec_WebSocket_Protocol=f"cohaptic, {offered}x") is HTTPStatus.FORBIDDEN


def test_each_server_has_a_token_of_its_own_that_nothing_shows() -> None:
    one, other = Access(hosts=frozenset()), Access(hosts=frozenset())
    assert one.token != other.token
    assert len(one.token) >= 32
    assert one.token not in repr(one)


@pytest.mark.parametrize("text", ["127.0.0.1", ":80", "127.0.0.1:http", "127.0.0.1:70000", "x:"])
def test_an_address_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"^--live-at: .*HOST:PORT"):
        listening(text)


@pytest.mark.parametrize("text", ["0.0.0.0:80", "[::]:80", "0:80", "0x0:80"])
def test_every_address_at_once_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"^--live-at: .*name the one that others use"):
        listening(text)


def test_only_loopback_goes_by_localhost() -> None:
    assert hosts_of("::1", 80) == {"[::1]:80", "localhost:80"}
    assert hosts_of("192.168.1.5", 80) == {"192.168.1.5:80"}
