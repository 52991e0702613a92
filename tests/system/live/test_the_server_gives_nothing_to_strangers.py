"""The served port against requests that no page of ours makes."""

from __future__ import annotations

import json
import socket
import struct
import time

import pytest

from tests.support.live.client import Page, ask, served, upgrade_headers


@pytest.fixture(scope="module")
def address():
    with served() as found:
        yield found


def test_page_and_modules_are_served_with_their_guards(address):
    for path in ("/", "/main.js", "/style.css", "/vendor/uPlot.js"):
        status, headers, body = ask(address, path)
        assert status == 200
        assert body
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "script-src 'self'" in policy
        assert "unsafe" not in policy
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["cache-control"] == "no-store"
        assert "set-cookie" not in headers
        assert "access-control-allow-origin" not in headers
        assert address.fragment.encode() not in body


@pytest.mark.parametrize("path", ["/../access.py", "/%2e%2e/access.py", "/nothing", "/?", "//"])
def test_nothing_but_the_page_is_served(address, path):
    assert ask(address, path)[0] == 404


@pytest.mark.parametrize("method", ["POST", "PUT", "HEAD", "DELETE", "OPTIONS"])
def test_only_get_is_answered(address, method):
    assert ask(address, "/", method)[0] == 405
    assert ask(address, "/socket", method, **upgrade_headers(address))[0] == 405


def test_a_rebound_name_gets_403(address):
    host = f"evil.example:{address.port}"
    assert ask(address, "/", host=host)[0] == 403
    headers = upgrade_headers(address) | {"Origin": f"http://{host}"}
    assert ask(address, "/socket", host=host, **headers)[0] == 403


def test_a_foreign_origin_and_a_missing_token_get_403(address):
    ours = upgrade_headers(address)
    assert ask(address, "/socket", **(ours | {"Origin": "http://evil.example"}))[0] == 403
    assert ask(address, "/socket", **upgrade_headers(address, token="guess"))[0] == 403
    del ours["Sec_WebSocket_Protocol"]
    assert ask(address, "/socket", **ours)[0] == 403


def test_the_token_opens_the_socket_and_is_not_said_back(address):
    page = Page(address)
    assert page.status == 101
    assert page.headers["sec-websocket-protocol"] == "cohaptic"
    assert page.message("waiting") == {"type": "waiting"}
    page.close()


def test_a_message_that_is_too_large_ends_the_connection(address):
    page = Page(address)
    page.say(b"x" * 5000)
    while (answer := page.hear())[0] != 8:
        pass
    assert struct.unpack(">H", answer[1][:2])[0] == 1009
    page.close()


@pytest.mark.parametrize(
    "said", [b"{", b"[]", b'"a"', b'{"ack":"1"}', b'{"watch":[1,null]}', b'{"hand":[1]}', b"\xff"]
)
def test_nonsense_is_dropped_or_ends_that_page_alone(address, said):
    page, other = Page(address), Page(address)
    page.say(said)
    other.say({"ack": 0})
    assert other.message("waiting") == {"type": "waiting"}
    for each in (page, other):
        each.close()
    assert ask(address)[0] == 200


def test_the_seventeenth_page_is_told_why_it_waits(address):
    pages = [Page(address) for _ in range(16)]
    status, _, body = ask(address, "/socket", **upgrade_headers(address))
    for page in pages:
        page.close()
    assert status == 503
    assert b"16 pages" in body


def test_it_listens_on_loopback_alone_and_ends_with_its_starter(address):
    with served() as other:
        port = other.port
        own = socket.gethostbyname(socket.gethostname())
        if not own.startswith("127."):
            with pytest.raises(OSError):
                socket.create_connection((own, port), timeout=1).close()
    until = time.monotonic() + 5
    while time.monotonic() < until:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1).close()
        except OSError:
            return
        time.sleep(0.05)
    pytest.fail("the server outlived who started it")


def test_a_port_that_is_taken_is_a_sentence(address):
    from cosim.base.errors import InputError
    from cosim.live.process import ServerProcess

    refused = pytest.raises(
        InputError, match=f"^--live-at: 127.0.0.1:{address.port} cannot be listened on"
    )
    with ServerProcess(("127.0.0.1", address.port), None) as server, refused:
        server.address()


def test_a_waiting_page_is_told_of_the_run_that_begins(address, tmp_path):
    from types import SimpleNamespace

    from cosim.realtime.live import Feed
    from cosim.realtime.ring import Ring

    ring = Ring.create(1, capacity=64)
    feed = Feed("nothing", 1000.0, {}, [ring])
    column = SimpleNamespace(name="a.x", unit="m", is_float=True)
    page = Page(address)
    page.say({"watch": ["a.x"]})
    try:
        feed.publish([SimpleNamespace(name="control", period=1, columns=[column])])
        run = page.message("run")
        assert run["signals"] == {"a.x": "m"}
        ring.write([0.25])
        frames = [page.message("frame") for _ in range(4)]
        assert [frame["number"] for frame in frames] == [1, 2, 3, 4]
        page.link.settimeout(0.5)
        with pytest.raises(TimeoutError):
            page.hear()
        for number in range(20):
            ring.write([float(number)])
        time.sleep(0.1)  # three pictures
        page.link.settimeout(5)
        page.say({"ack": 4})
        frame = page.message("frame")
        assert json.dumps(frame["rows"]).count("19.0") == 1
    finally:
        feed.remove()
        ring.remove()
    page.say({"ack": 5})
    assert page.message("ended") == {"type": "ended"}
    page.close()
