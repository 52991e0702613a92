"""docs/protocol.md is enough: a client that was written from it takes part in a session."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import pytest

from cosim.link.session.contract import Contract
from tests.support.link import independent_client
from tests.support.link.independent_client import Client, read_key_line
from tests.support.link.whole import MILLISECOND, RATE, SECOND, Station, Wire, position
from tests.support.link.whole import SkewedClock as Clock

WAY = 3 * MILLISECOND
ACTIVE = 1 | 2 | 8


def run(client: Client, until: int, *, replies: int = 0, station: Station | None = None):
    """Our station "a" and the client "b" in simulated time; the first ``replies`` are lost."""
    lost = [0]

    def treat(source: str, target: str, datagram: bytes, now: int):
        if datagram[3] == independent_client.REPLY and lost[0] < replies:
            lost[0] += 1
            return []
        return [(now + WAY, datagram)]

    wire = Wire(treat)
    a = station or Station("a", ["b"], wire, Clock(4 * 10**12, 3e-5))
    clock = Clock(-(10**10), -2e-5)

    def send(datagrams: list[bytes]) -> None:
        for datagram in datagrams:
            wire.send("b", "a", datagram)

    while wire.now < until:
        wire.now += MILLISECOND
        while wire.queue and wire.queue[0][0] <= wire.now:
            _, _, source, target, content = wire.queue.pop(0)
            wire.queue.sort()
            if target == "a":
                a.arrive(source, content)
            else:
                send(client.receive(content, clock.at(wire.now)))
        a.step_process()
        if not a.running:
            a.wait()
        elif a.clock.at(wire.now) >= a.deadline:
            a.run_tick()
        send(client.poll(clock.at(wire.now)))
        due = client.deadline()
        if due is not None and clock.at(wire.now) >= due:
            own = (position("b", wire.now), 0.0, 0.0, float(ACTIVE))
            send(client.run_tick(own, clock.at(wire.now)))
    return a, wire


def client(contract: dict | None = None, key: bytes = bytes(32)) -> Client:
    contract = contract or {"protocol": "2", "rate": "128.0"}
    return Client("b", "a", key, contract, rate=RATE, values=4)


def test_it_imports_nothing_of_ours() -> None:
    tree = ast.parse(Path(independent_client.__file__).read_text(encoding="utf-8"))
    modules = {
        name.split(".")[0]
        for node in ast.walk(tree)
        for name in (
            [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else []
        )
    }
    assert modules.isdisjoint({"cosim", "hil", "fmus", "tests"})


@pytest.mark.parametrize("replies", [0, 3])
def test_it_meets_starts_and_exchanges_values_with_our_station(replies: int) -> None:
    other = client()
    a, wire = run(other, 6 * SECOND, replies=replies)
    samples = a.samples["b"]
    assert samples[-1].weight == 1.0
    assert abs(samples[-1].value - position("b", wire.now)) < 0.05
    assert abs(other.values[0] - position("a", wire.now)) < 0.05
    assert other.values[1] == other.shown_tick
    receiver = a.remotes["b"].link.incoming[0].receiver
    assert sum(receiver.tally) == receiver.tally[0] + receiver.tally[11]
    # Both began at one instant, and both ends see that they are heard.
    assert a.grid.first_tick == other.first_tick == 0
    assert max(sample.weight for sample in samples[: RATE // 4]) == 1.0
    assert a.process.sessions == 1


def test_it_is_refused_with_our_contract_where_its_own_differs() -> None:
    other = client({"protocol": "2", "rate": "64.0"})
    a, _ = run(other, SECOND)
    assert a.negotiator.side(0).current is None
    assert json.loads(other.their_text) == dict(Contract({"rate": RATE}).entries)
    (refusal,) = a.negotiator.side(0).refusal.differences
    assert refusal == "rate: 128.0 at a, 64.0 at b"


def test_it_gets_nowhere_with_another_key() -> None:
    other = client(key=bytes([7]) * 32)
    a, _ = run(other, SECOND)
    assert a.negotiator.side(0).current is None
    assert a.negotiator.side(0).drops.foreign > 10


def test_a_key_file_is_what_the_page_says(tmp_path) -> None:
    from cosim.link.session.keys import create_key_file, read_key_file

    create_key_file(tmp_path / "key")
    secret = read_key_line((tmp_path / "key").read_text())
    ours = read_key_file(tmp_path / "key")
    mine = independent_client.hkdf(
        secret, independent_client.lengths(b"cohaptic link", b"\x02", b"noise", b"x")
    )
    assert mine == ours.derive("noise", context=b"x")


def test_the_contract_is_serialised_as_the_page_says() -> None:
    contract = Contract({"b": [1, 2.5], "a": {"x10": True, "x9": "ü"}, "n": 2**60, "s": 1e-5})
    text = (
        '{"a.x9":"ü","a.x10":"true","b[1]":"1.0","b[2]":"2.5","n":"1152921504606846976",'
        '"protocol":"2","s":"1e-05"}'
    )
    import hashlib

    assert contract.hash == hashlib.sha256(text.encode()).digest()
