"""netchar recovers what a network does, with the link's authentication and without amplifying."""

from __future__ import annotations

import itertools
import json
import random
import socket
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError, RunError
from cosim.cli.netchar import command
from cosim.link.netchar.bursts import LossPattern, fit_bursts
from cosim.link.netchar.measurement import NetworkMeasurement
from cosim.link.netchar.preset import channel_preset
from cosim.link.netchar.probe import Probe, check_measurement
from cosim.link.netchar.relay import (
    ECHO,
    OVERHEAD,
    SMALLEST,
    Caps,
    Relay,
    serve,
)
from cosim.link.netchar.search import search_rate
from cosim.link.netchar.statistics import Characteristics, characterise
from cosim.link.session.asker import RETRY
from cosim.link.session.greeting import GREETING_SIZE
from cosim.link.wire.address import Address
from cosim.link.wire.packet import PacketKind
from cosim.link.wire.sockets import open_socket
from cosim.testing.impairment import BadNetwork, Impairer, Injected
from cosim.testing.proxy import Proxy
from tests.support.link.measured import measured, peak
from tests.support.link.relay_client import Session
from tests.support.link.support import KEY, OTHER_KEY
from tests.support.machine import timed

LOCAL = Address("127.0.0.1", 0)


@contextmanager
def relay_behind(forward: BadNetwork, backward: BadNetwork, key=KEY, caps=None):
    """A relay with a proxy in front, each in a thread; yields (where to probe, proxy, relay)."""
    stop = threading.Event()
    link = open_socket(LOCAL, None)
    relay = Relay(key, caps or Caps())
    proxy = Proxy(LOCAL, Address(*link.getsockname()), Impairer(forward, 5), Impairer(backward, 6))
    threads = [
        threading.Thread(
            target=serve,
            args=(link, relay),
            kwargs={"stop": stop.is_set, "report": lambda: None},
        ),
        threading.Thread(target=proxy.run, args=(stop,)),
    ]
    for thread in threads:
        thread.start()
    try:
        yield proxy.address, proxy, relay
    finally:
        stop.set()
        for thread in threads:
            thread.join()
        link.close()


THERE = BadNetwork(delay=0.040, jitter=0.008, loss=0.04)
BACK = BadNetwork(delay=0.025, jitter=0.005, loss=0.02)


def check_losses(found, forward, backward) -> None:
    """Losses to the packet; nothing was forged."""
    assert found.loss.packets == forward.lost + backward.lost
    assert found.forged == 0


def check_recovered(found, forward, backward, delays=None) -> None:
    """Delay and jitter within 5 % of what was injected, losses to the packet."""
    delays = [np.array(way) for way in delays or (forward.delays, backward.delays)]
    check_losses(found, forward, backward)
    assert found.round_trip.mean == pytest.approx(sum(d.mean() for d in delays), rel=0.05)
    assert found.forward.rms_jitter == pytest.approx(delays[0].std(), rel=0.05)
    assert found.backward.rms_jitter == pytest.approx(delays[1].std(), rel=0.05)
    # Which way a packet was lost is told up to what overtook at both ends of the measurement.
    assert found.loss.forward == pytest.approx(forward.lost, rel=0.2, abs=12)


def test_injected_delay_jitter_and_loss_are_recovered_within_five_percent() -> None:
    """Every byte of relay and statistics, in simulated time: no scheduler in between."""
    count, offset, skew = 8000, 10**15, 40e-6
    forward, backward = Impairer(THERE, 1), Impairer(BACK, 2)
    relay = Relay(KEY, Caps())
    session = Session(relay, now=offset)
    times = np.zeros((4, count), dtype=np.int64)
    times[0] = (np.arange(count) * 1e9 / 400).astype(np.int64) + 10**9
    arrivals = [
        (due, number, content)
        for number in range(count)
        for due, content in forward.take(session.probe(int(times[0, number])), times[0, number])
    ]
    counted: list[tuple[int, int]] = []
    for due, number, content in sorted(arrivals):
        at = offset + round(due * (1 + skew))
        answer = session.ask(content, at)
        assert answer is not None
        plain = memoryview(bytearray(len(answer) - OVERHEAD))
        assert session.opener.open(memoryview(answer), plain)
        _, times[1, number], times[2, number], received, _ = ECHO.unpack_from(plain)
        for back, _ in backward.take(answer, int(due)):
            times[3, number] = back
            counted.append((number, received))
    lost = times[3] == 0
    times[1:3, lost] = 0
    found = characterise(
        measured(400, times[0], times[3], times[1], times[2], counts=dict(counted))
    )
    check_recovered(found, forward.injected, backward.injected)
    assert found.clock_skew == pytest.approx(skew, abs=20e-6)
    assert found.loss.fraction == pytest.approx(0.04 + 0.96 * 0.02, rel=0.1)


def measured_through(proxy: Proxy, relay: Relay, probe: Probe, count: int) -> NetworkMeasurement:
    """Over when every packet was lost or is back, however long that takes on a busy machine."""
    for side in (proxy.forward, proxy.backward):
        side.injected = Injected()
    for delays in proxy.delays:
        delays.clear()
    proxy.lateness.clear()
    looks = 0

    def done() -> bool:
        nonlocal looks
        there, back = proxy.forward.injected, proxy.backward.injected
        over = len(there.outcomes) == count and relay.received == there.passed
        over = over and len(back.outcomes) >= relay.received and proxy.idle
        # Two looks, so that the last packet has been read in between.
        looks = looks + 1 if over else 0
        return looks > 2

    return probe.measure(rate=300, duration=count / 300, wait=120.0, stop=done)


STALL = 2e-3
"""A machine that wakes a process so late (s) may as well stall between stamp and sending."""
RELEASED = 1e-3
"""99 of 100 packets have to leave the proxy within this (s) of their time."""


@pytest.mark.slow
def test_what_a_proxy_did_to_each_packet_is_recovered_through_real_sockets() -> None:
    """Against the delays that the proxy really made, so that the machine's own cancel out.

    Not in the proxy's book is a stall between a packet's stamp and its sending: where releases show
    that the machine stalls, the times are void and the losses are not.
    """
    with relay_behind(THERE, BACK) as (address, proxy, relay), open_socket(LOCAL, address) as link:
        probe = Probe(link, KEY)
        probe.connect(timeout=60.0)
        # Answers to greetings that were sent twice come back in here, if there are any.
        measured_through(proxy, relay, probe, 60)

        def attempt(_: int) -> bool | str:
            found = characterise(measured_through(proxy, relay, probe, 900))
            injected = proxy.forward.injected, proxy.backward.injected
            check_losses(found, *injected)
            try:
                check_recovered(found, *injected, proxy.delays)
            except AssertionError as error:
                return f"{error}"
            return True

        assert timed(attempt, tolerates=STALL)


@pytest.mark.slow
def test_what_was_asked_of_the_proxy_is_recovered_through_real_sockets() -> None:
    """Against the delays drawn: needs a machine that releases a packet in time."""

    def attempt(_: int) -> tuple[Characteristics, tuple[Injected, Injected], Proxy, float] | str:
        with (
            relay_behind(THERE, BACK) as (address, proxy, relay),
            open_socket(LOCAL, address) as link,
        ):
            probe = Probe(link, KEY)
            probe.connect(timeout=60.0)
            found = characterise(measured_through(proxy, relay, probe, 9000))
            late = float(np.percentile(proxy.lateness, 99))
        if late > RELEASED:
            return f"packets were released {late:.4f} s late"
        return found, (proxy.forward.injected, proxy.backward.injected), proxy, late

    found, injected, proxy, late = timed(attempt, tolerates=STALL, attempts=4)
    print(
        f"released late by {np.median(proxy.lateness) * 1e6:.0f} us median, {late * 1e6:.0f} p99; "
        f"round trip {found.round_trip.mean * 1e3:.3f} ms, jitter there "
        f"{found.forward.rms_jitter * 1e3:.3f}, back {found.backward.rms_jitter * 1e3:.3f} ms, "
        f"lost {found.loss.forward} there, {found.loss.backward} back"
    )
    check_recovered(found, *injected)


class FirstOnly:
    """Impairs the first packets and passes the last ones, behind which no copy is still coming."""

    def __init__(self, impairer: Impairer, count: int) -> None:
        self.impairer, self.left = impairer, count

    def take(self, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        self.left -= 1
        return self.impairer.take(datagram, now) if self.left >= 0 else [(now, datagram)]


def test_copies_and_overtaking_are_counted() -> None:
    # A hundred at once, which is what a stalled machine makes of it, fit a socket's buffer.
    count = 100
    back = Impairer(BadNetwork(duplicate=0.2, reorder=0.1), 6)
    with (
        relay_behind(BadNetwork(), BadNetwork()) as (address, proxy, _),
        open_socket(LOCAL, address) as link,
    ):
        probe = Probe(link, KEY)
        probe.connect(timeout=60.0)
        proxy.backward = FirstOnly(back, count - 20)
        found = characterise(probe.measure(rate=100, duration=1, wait=120.0))
    assert found.duplicates == back.injected.duplicated > 5
    assert 0 < found.reordered <= back.injected.reordered
    assert found.loss.packets == 0


def test_a_relay_with_another_key_does_not_answer() -> None:
    with relay_behind(BadNetwork(), BadNetwork(), key=OTHER_KEY) as (address, _, relay):
        with (
            open_socket(LOCAL, address) as link,
            pytest.raises(RunError, match="no relay answer"),
        ):
            Probe(link, KEY).connect(timeout=0.3)
        while not relay.handshakes_failed:  # its thread may not have run yet
            time.sleep(0.01)


@pytest.mark.parametrize("size", [SMALLEST, 280, 1200, 1232])
def test_an_answer_is_exactly_as_long_as_its_question(size: int) -> None:
    session = Session(Relay(KEY, Caps()))
    answer = session.ask(session.probe(7, size), 9)
    assert answer is not None
    assert len(answer) == size
    plain = memoryview(bytearray(size - OVERHEAD))
    assert session.opener.open(memoryview(answer), plain)
    assert ECHO.unpack_from(plain) == (7, 9, 9, 1, 0)


def test_nothing_unauthentic_and_nothing_twice_is_answered() -> None:
    relay = Relay(KEY, Caps())
    session = Session(relay)
    first = session.probe(1)
    assert session.ask(first, 1) is not None
    assert session.ask(first, 2) is None
    changed = bytearray(session.probe(2))
    changed[40] ^= 1
    assert session.ask(bytes(changed), 3) is None
    assert session.ask(session.probe(3), 4, sender=("10.0.0.9", 5000)) is None
    assert session.ask(bytes(60), 5) is None
    assert session.ask(b"", 6) is None
    assert session.ask(bytes(GREETING_SIZE), 6) is None
    assert relay.received == 1


@pytest.mark.parametrize("restarted", [False, True])
def test_a_recorded_greeting_gets_a_cookie_and_nothing_else(*, restarted: bool) -> None:
    """Whoever sends it from an address that he does not have makes the relay send it little."""
    relay = Relay(KEY, Caps())
    greetings = Session(relay).greetings
    if restarted:
        # One that has never seen them.
        relay = Relay(KEY, Caps())
    cookies = 0
    for seconds in range(3, 100):
        for greeting in greetings:
            at = seconds * 10**9
            answer = relay.take(memoryview(greeting), ("10.0.0.9", 1), at, lambda t=at: t)
            assert answer is None or (answer[3] == PacketKind.COOKIE and len(answer) < 120)
            cookies += answer is not None
    assert relay.received == 0
    assert (cookies > 0) is restarted


class Endless(socket.socket):
    """A socket that datagrams never cease to come from."""

    def __init__(self) -> None:
        super().__init__(socket.AF_INET, socket.SOCK_DGRAM)
        self.bind(("127.0.0.1", 0))
        self.connect(self.getsockname())
        self.setblocking(False)
        super().send(b"so that it is readable")
        self.read = 0

    def recv_into(self, buffer, *_rest) -> int:
        self.read += 1
        size = min(len(buffer), 100)
        buffer[:size] = bytes(size)
        return size

    def recvfrom_into(self, buffer, *_rest):
        return self.recv_into(buffer), ("10.0.0.9", 1)

    def send(self, datagram, *_rest) -> int:
        return len(datagram)


def test_packets_without_end_keep_nobody_from_the_clock() -> None:
    with Endless() as link:
        ends = iter([False, False, True])
        serve(link, Relay(KEY, Caps()), stop=lambda: next(ends), report=lambda: None)
        assert 0 < link.read <= 3 * 256
    with Endless() as link:
        probe, session = Probe(link, KEY), Session(Relay(KEY, Caps()))
        probe.converse(session.asker.current.keys)
        found = characterise(probe.measure(rate=100, duration=0.05, wait=0.0))
        assert found.sent == 5
        assert found.forged > 0


class Full(socket.socket):
    """A socket whose queue takes only every other packet."""

    calls = 0

    def send(self, datagram, *_rest) -> int:
        self.calls += 1
        if self.calls % 2:
            raise BlockingIOError
        return len(datagram)


def test_what_this_computer_could_not_send_is_not_called_lost() -> None:
    with Full(socket.AF_INET, socket.SOCK_DGRAM) as link:
        link.bind(("127.0.0.1", 0))
        link.setblocking(False)
        probe, session = Probe(link, KEY), Session(Relay(KEY, Caps()))
        probe.converse(session.asker.current.keys)
        found = characterise(probe.measure(rate=1000, duration=0.02, wait=0.0))
    assert (found.sent, found.unsent, found.loss.packets) == (20, 10, 10)


@pytest.mark.parametrize("value", ["nan", "0", "-1", "inf"])
def test_a_cap_that_cannot_be_is_refused_by_the_command(value: str) -> None:
    for name in ("--max-rate", "--max-duration"):
        result = CliRunner().invoke(command, ["serve", f"{name}={value}"])
        assert result.exit_code == 2
        assert name in result.output


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_cap_that_cannot_be_is_refused(value: float) -> None:
    for name in ("rate", "duration"):
        with pytest.raises(InputError, match=rf"cannot be \(--max-{name}\)"):
            Caps(**{name: value})


def test_what_the_caps_keep_back_is_not_called_lost() -> None:
    with (
        relay_behind(BadNetwork(), BadNetwork(), caps=Caps(rate=100.0)) as (address, _, relay),
        open_socket(LOCAL, address) as link,
    ):
        probe = Probe(link, KEY)
        probe.connect(timeout=60.0)
        found = characterise(probe.measure(rate=2000, duration=0.5, wait=5.0))
    assert found.capped > 500
    assert relay.capped >= found.capped
    # The relay tells with its last answer; what it kept back after that looks lost.
    assert found.loss.packets <= 40


def test_a_reply_to_an_earlier_measurement_is_late_and_not_forged() -> None:
    with (
        relay_behind(BadNetwork(), BadNetwork(delay=0.25)) as (address, _, _relay),
        open_socket(LOCAL, address) as link,
    ):
        probe = Probe(link, KEY)
        probe.connect(timeout=60.0)
        first = probe.measure(rate=200, duration=0.05, wait=0.0)
        second = probe.measure(rate=200, duration=0.05, wait=5.0)
    assert first.returned == 0
    assert second.late_replies == first.count
    assert second.forged == 0
    assert second.returned == second.count


def test_rate_and_duration_are_capped() -> None:
    relay = Relay(KEY, Caps(rate=100.0, duration=10.0))
    session = Session(relay)
    answers = [session.ask(session.probe(n), n * 1_000_000) for n in range(1, 5001)]
    assert 500 <= sum(a is not None for a in answers) <= 500 + 33
    assert session.ask(session.probe(9), 11 * 10**9) is None


def test_a_running_measurement_is_not_taken_over() -> None:
    relay = Relay(KEY, Caps())
    session = Session(relay)
    assert session.ask(session.probe(1), RETRY) is not None
    second = Session(relay, ("10.0.0.9", 1), now=2 * RETRY)
    assert not second.connected
    assert second.asker.busy
    assert session.ask(session.probe(2), 3 * RETRY) is not None
    assert Session(relay, ("10.0.0.9", 1), now=10 * 10**9).connected


def test_a_day_at_the_highest_rate_is_planned_in_the_memory_of_a_second() -> None:
    with (
        relay_behind(BadNetwork(), BadNetwork()) as (address, _, _relay),
        open_socket(LOCAL, address) as link,
    ):
        probe = Probe(link, KEY)
        probe.connect(timeout=60.0)

        def some_of(duration: float) -> Callable[[], object]:
            looks = itertools.count()
            return lambda: probe.measure(
                rate=1e5, duration=duration, wait=1.0, stop=lambda: next(looks) > 20
            )

        second, day = peak(some_of(1.0)), peak(some_of(86_400.0))
    assert check_measurement(1e5, 86_400.0, 280) == 8_640_000_000
    assert day < 64 << 20
    assert day == pytest.approx(second, rel=0.05)


def losses(seed: int, count: int, good_to_bad: float, bad_to_good: float, loss_bad: float):
    draw = random.Random(seed)
    bad = draw.random() < good_to_bad / (good_to_bad + bad_to_good)
    lost = np.zeros(count, dtype=bool)
    for number in range(count):
        if draw.random() < (bad_to_good if bad else good_to_bad):
            bad = not bad
        lost[number] = bad and draw.random() < loss_bad
    return lost


def pattern(lost) -> LossPattern:
    found = LossPattern()
    found.add(lost)
    return found


@pytest.mark.parametrize("loss_bad", [1.0, 0.5])
def test_the_fitted_bursts_are_those_that_made_the_losses(loss_bad: float) -> None:
    """A tenth: the standard error of Gilbert's estimates at this length is about 3 %."""
    fit = fit_bursts(pattern(losses(3, 400_000, 0.005, 0.1, loss_bad)))
    assert fit is not None
    assert fit.good_to_bad == pytest.approx(0.005, rel=0.12)
    assert fit.bad_to_good == pytest.approx(0.1, rel=0.12)
    assert fit.loss_bad == pytest.approx(loss_bad, rel=0.05)


@pytest.mark.parametrize("probability", [0.0, 0.001, 0.05, 0.5])
def test_independent_losses_are_no_bursts(probability: float) -> None:
    draw = np.random.default_rng(1)
    assert fit_bursts(pattern(draw.random(50_000) < probability)) is None


def measurement(rate: float, trip: float = 0.002, lost: float = 0.0, growth: float = 0.0):
    count = 200
    sent = (np.arange(count) * 1e9 / rate).astype(np.int64) + 1
    trips = (trip + growth * np.arange(count)) * 1e9
    returned = sent + trips.astype(np.int64)
    returned[: int(lost * count)] = 0
    half = ((sent + returned) // 2) * (returned > 0)
    return measured(rate, sent, returned, half, half)


def test_the_search_finds_the_knee_of_a_shaper() -> None:
    def shaper(rate: float) -> NetworkMeasurement:
        return measurement(rate, lost=max(0.0, 1.0 - 1500.0 / rate))

    found = search_rate(shaper)
    assert 1500.0 / 1.1 <= found.achievable <= 1510.0
    assert "lost" in found.limit


def test_the_search_sees_a_queue_that_grows_and_its_own_end() -> None:
    found = search_rate(lambda rate: measurement(rate, growth=1e-4 if rate > 600 else 0.0))
    assert 540 <= found.achievable <= 600
    assert "queue" in found.limit
    free = search_rate(measurement, highest=1000.0)
    assert free.achievable == 1000.0
    assert free.limit == "the highest rate that was tried"


def test_the_preset_is_a_channel_of_a_scenario() -> None:
    from ruamel.yaml import YAML

    found = characterise(measurement(128.0, trip=0.010))
    channel = YAML(typ="safe").load(channel_preset(found, name="there"))
    assert channel["delay"] == {"forward": "5.0000 ms", "backward": "5.0000 ms"}
    assert channel["loss"] == {"forward": 0, "backward": 0}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["probe", "127.0.0.1"], "SERVER is host:port"),
        (["probe", "192.0.2.1:5000"], "there is no key"),
        (["serve", "--listen", "0.0.0.0:0"], "there is no key"),
        (["serve", "--listen", "192.0.2.77:0", "--key", "KEY"], "cannot listen on"),
    ],
)
def test_what_cannot_be_is_a_sentence(options, message, tmp_path) -> None:
    from cosim.link.session.keys import create_key_file

    create_key_file(tmp_path / "KEY")
    options = [str(tmp_path / o) if o == "KEY" else o for o in options]
    result = CliRunner().invoke(command, options)
    assert isinstance(result.exception, InputError)
    assert message in str(result.exception)


def test_the_probe_command_prints_one_json_object_and_writes_preset_and_figure(
    tmp_path, monkeypatch
) -> None:
    monkeypatch.setattr("cosim.cli.netchar._key", lambda path: KEY)
    monkeypatch.setattr("signal.signal", lambda *_: None)
    with relay_behind(BadNetwork(), BadNetwork()) as (address, _, _relay):
        result = CliRunner().invoke(
            command,
            [
                "probe",
                str(address),
                "--duration=0.3",
                f"--out={tmp_path / 'lan.yaml'}",
                f"--figure={tmp_path / 'lan.png'}",
                "--json",
            ],
            catch_exceptions=False,
        )
    facts = json.loads(result.stdout)
    assert facts["sent"] == 38
    assert facts["round_trip"]["mean"] > 0
    assert (tmp_path / "lan.png").stat().st_size > 1000
    assert "jitter:" in (tmp_path / "lan.yaml").read_text()
