"""Over waves the channel only takes energy, at any delay and under loss, and conveys contact."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
import pytest

from tests.support.physics.planar_oracle import Array, Bench, T

RATIO, HAND, B = 8, 0.1, 10.0
HARD = {
    "mass": 1e9,
    "inertia": 1e9,
    "remote_normal_stiffness": 800.0,
    "network_ticks": RATIO,
}


def packet(bench: Bench, terminal: str) -> dict[str, Any]:
    members = next(t for t in bench.instance.model.terminals if t.name == terminal).members
    return {name: bench[path] for name, path in members.items()}


class Wire:
    """Packets every RATIO ticks, ``samples`` late, some of them lost."""

    def __init__(self, samples: int, loss: float, seed: int) -> None:
        self.queue: deque[dict[str, Any]] = deque(maxlen=samples + 1)
        self.loss, self.rng, self.seen = loss, np.random.default_rng(seed), None

    def exchange(self, tick: int, bench: Bench, terminal: str) -> dict[str, Any]:
        if tick % RATIO == 0:
            now = packet(bench, terminal)
            self.queue.extend([now] * (1 if self.queue else self.queue.maxlen or 1))
            if self.seen is None or self.rng.random() >= self.loss:
                self.seen = self.queue[0]
        assert self.seen is not None
        return self.seen


def hit_the_box(
    channel: int, delay: int, *, loss: float = 0.0, ticks: int = 1500, push: float = 1.0
) -> dict[str, Array]:
    """A free hand of 0.1 kg pushed by a held force against a far box that cannot move."""
    server = Bench("central_server", [(0.5, 0.5)], force_channel=channel, wave_impedance=B, **HARD)
    client = Bench("remote_client", [(0.0, 0.05)], force_channel=channel, wave_impedance=B)
    server.put((0.5, 0.5))
    up, down = Wire(delay, loss, 1), Wire(delay, loss, 2)
    y, v = 0.054, 0.0
    log: dict[str, list[float]] = {name: [] for name in ("y", "v", "felt", "pressed")}
    for tick in range(ticks):
        client.put((0.0, y))
        for bench, group, wire, other, terminal in (
            (server, "client_1", up, client, "up"),
            (client, "down", down, server, "to_client_1"),
        ):
            for name, value in wire.exchange(tick, other, terminal).items():
                bench[f"{group}.{name}"] = value
        felt = client["finger_1.force"][1]
        for name, value in {
            "y": y,
            "v": client["finger_1.velocity"][1],
            "felt": felt,
            "pressed": server["client_contact_1.finger_1_normal_force"],
        }.items():
            log[name].append(value)
        server.step()
        client.step()
        force = felt - push
        y, v = y + T * v + 0.5 * T * T * force / HAND, v + T * force / HAND
        y = float(np.clip(y, 0.0, 0.08))
    return {name: np.array(values) for name, values in log.items()}


@pytest.mark.parametrize("delay", [0, 4])
def test_contact_settles_at_any_delay(delay: int) -> None:
    log = hit_the_box(1, delay, ticks=6000)
    assert np.ptp(log["y"][-500:]) < 0.08 * np.ptp(log["y"][:1500])
    assert log["felt"][-1] == pytest.approx(1.0, abs=0.1)
    assert log["pressed"][-1] == pytest.approx(1.0, abs=0.1)
    assert log["y"][-1] < 0.05


def test_the_plain_channel_does_not() -> None:
    log = hit_the_box(0, 2)
    assert log["y"].max() > 0.07


@pytest.mark.parametrize(("delay", "loss"), [(0, 0.0), (2, 0.0), (4, 0.0), (1, 0.3), (0, 0.6)])
def test_energy_that_comes_back_was_put_in(delay: int, loss: float) -> None:
    """What the hand has put into the channel, less what is stored in the far spring."""
    log = hit_the_box(1, delay, loss=loss)
    put_in = -np.cumsum(T * log["felt"] * log["v"])
    assert put_in.min() > -1e-6


def test_hand_and_its_image_stay_together_under_loss() -> None:
    log = hit_the_box(1, 1, loss=0.3, ticks=3000)
    assert log["pressed"][-500:].mean() == pytest.approx(1.0, abs=0.02)
    # The image lags by the delay: force times delay over the impedance, and does not drift away.
    longest = 2 * 8 * RATIO * T / B
    assert abs(log["y"][-500:].mean() - (0.05 - 1.0 / 800.0)) < longest
    assert abs(log["y"][-500:].mean() - log["y"][-1000:-500].mean()) < 5e-4


def test_free_motion_passes_through() -> None:
    """Far from the box the wave comes back whole, and the hand feels only the delay."""
    log = hit_the_box(1, 1, ticks=20, push=-1.0)
    assert np.all(log["pressed"] == 0.0)
    assert np.abs(log["felt"]).max() < 1.0


def test_an_impedance_of_zero_is_refused() -> None:
    for model in ("central_server", "remote_client"):
        with pytest.raises(Exception, match="wave_impedance"):
            Bench(model, [(0.0, 0.0)], force_channel=1, wave_impedance=0.0)


@pytest.mark.parametrize("restarted", [False, True])
def test_a_client_that_comes_back_is_heard_anew(restarted: bool) -> None:
    """Neither what it sent while it did not count is played, nor is a lasting delay left."""
    server = Bench("central_server", [(0.5, 0.5)], force_channel=1, wave_impedance=B, **HARD)
    server.put((0.5, 0.5))
    server["client_1.status"] = 2
    away, back = range(800, 2400), 2400
    integral, first, played = 0.0, 0, []
    for tick in range(3200):
        if restarted and tick == back:
            integral, first = 0.0, back
        server["peer_weight[1]"] = float(tick not in away)
        if tick % RATIO == 0:
            server["client_1.source_tick"] = tick - first
            server["client_1.finger_1_wave"] = (integral, 0.0)
        before = server["to_client_1.finger_1_wave"][0]
        server.step()
        # Far from the box all of a wave comes back, so that the rate is the wave that is played.
        played.append((server["to_client_1.finger_1_wave"][0] - before) / T)
        integral += T * (8.0 if tick in away else 2.0)
    assert played[2 * RATIO : away[0]] == pytest.approx([2.0] * (away[0] - 2 * RATIO))
    assert played[away[0] : away[-1]] == pytest.approx([0.0] * (len(away) - 1))
    assert max(played[back:]) == pytest.approx(2.0)
    assert played[back + 3 * RATIO :] == pytest.approx([2.0] * (800 - 3 * RATIO))
