"""Two users squeeze the box along one axis: the chain of models is the linear system of chapter 4.

Friction and quantisation are off and the velocity is estimated as a difference. The linear side is
one matrix per tick on [1, positions, velocities, held values], written from the wrench balances
alone. Contact is never lost, so nothing of the models' state machines may show.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.support.physics.planar_oracle import Array, Bench, T

HALF, HAND, MASS, RATIO, TICKS = 0.05, 0.1, 0.4, 8, 400
LOCAL, REMOTE, COUPLING = (800.0, 3.0), (170.0, 3.0), (77.5, 10.0)
SQUEEZE, EXTRA, EXTRA_FROM = 1.0, 0.25, 100
"""Held forces of both hands on the box, and an extra push of the first (N) from a tick on."""

START = (-0.0488, 0.0480)
"""Where the fingers start, inside of the faces at -0.05 and 0.05 (m)."""

FREE = {"integration": 2, "ground_friction": 0.0, "ground_rotational_friction": 0.0, "mass": MASS}
TOLERANCE = 1e-9


class Wire:
    """A packet every RATIO ticks, seen ``samples`` packets later; the first one until then."""

    def __init__(self, samples: int) -> None:
        self.packets: deque[Any] = deque(maxlen=samples + 1)

    def exchange(self, tick: int, sample: Callable[[], Any]) -> Any:
        """What the receiver sees at this tick."""
        if tick % RATIO == 0:
            packet = sample()
            self.packets.extend([packet] * (1 if self.packets else self.packets.maxlen or 1))
        return self.packets[0]


def move(x: Array, v: Array, force: Array, tick: int) -> tuple[Array, Array]:
    """Exact zero-order hold of both hands over one tick under rendered and own forces (N)."""
    own = [SQUEEZE + (EXTRA if tick >= EXTRA_FROM else 0.0), -SQUEEZE]
    total = force + own
    return x + T * v + 0.5 * T * T * total / HAND, v + T * total / HAND


def packet(bench: Bench, terminal: str) -> dict[str, Any]:
    """The members of an output terminal."""
    members = next(t for t in bench.instance.model.terminals if t.name == terminal).members
    return {name: bench[path] for name, path in members.items()}


def deliver(bench: Bench, group: str, values: dict[str, Any]) -> None:
    """Write a packet into an input group."""
    for name, value in values.items():
        bench[f"{group}.{name}"] = value


def distributed_models(delays: tuple[int, int]) -> Array:
    """Hand and box positions (m) of both users: [x_h1, x_h2, x_o1, x_o2] by tick."""
    users = [
        Bench("distributed_workstation", [(0.0, -0.06)], [np.pi], **FREE),
        Bench("distributed_workstation", [(0.0, 0.06)], **FREE),
    ]
    x, v, out = np.array(START), np.zeros(2), []
    wires = [Wire(n) for n in delays]
    for tick in range(TICKS):
        for bench, place in zip(users, x, strict=True):
            bench.put((0.0, place))
        seen = [
            wire.exchange(tick, lambda bench=bench: packet(bench, "shared"))
            for wire, bench in zip(wires, users, strict=True)
        ]
        for bench, values in zip(users, reversed(seen), strict=True):
            deliver(bench, "peer_1", values)
        out.append([*x, *(bench["box_pose.y"] for bench in users)])
        force = np.array([bench["finger_1.force"][1] for bench in users])
        for bench in users:
            bench.step()
            assert bench["finger_1.contact_losses"] == 0
        x, v = move(x, v, force, tick)
    return np.array(out)


def centralized_models(delays: tuple[int, int]) -> Array:
    """Hand and box positions (m): [x_h1, x_h2, x_o] by tick; user 1 is at the server."""
    server = Bench("central_server", [(0.0, -0.06)], [np.pi], **FREE)
    client = Bench("remote_client", [(0.0, 0.06)])
    up, down = (Wire(n) for n in delays)
    x, v, out = np.array(START), np.zeros(2), []
    for tick in range(TICKS):
        server.put((0.0, x[0]))
        client.put((0.0, x[1]))
        deliver(server, "client_1", up.exchange(tick, lambda: packet(client, "up")))
        deliver(client, "down", down.exchange(tick, lambda: packet(server, "to_client_1")))
        out.append([*x, server["box_pose.y"]])
        force = np.array([bench["finger_1.force"][1] for bench in (server, client)])
        server.step()
        client.step()
        assert server["client_contact_1.finger_1_contact_losses"] == 0
        x, v = move(x, v, force, tick)
    return np.array(out)


class Linear:
    """z(k+1) = step (sample) z(k), with rows written in the names of the entries."""

    def __init__(self, start: dict[str, float]) -> None:
        self.start = {"one": 1.0, **start}
        self.index = {name: i for i, name in enumerate(self.start)}
        size = len(self.index)
        self.step, self.sample, self.push = np.eye(size), np.eye(size), np.zeros(size)

    def __call__(self, **terms: float) -> Array:
        row = np.zeros(len(self.index))
        for name, value in terms.items():
            row[self.index[name]] = value
        return row

    def mass(self, m: float, x: str, v: str, force: Array) -> None:
        """A mass under a held force."""
        self.step[self.index[x]] += self(**{v: T}) + 0.5 * T * T / m * force
        self.step[self.index[v]] += T / m * force

    def run(self, shown: list[str]) -> Array:
        z, out = np.array(list(self.start.values())), []
        for tick in range(TICKS):
            if tick % RATIO == 0:
                z = self.sample @ z
            out.append(z[[self.index[name] for name in shown]])
            z = self.step @ z + (self.push if tick >= EXTRA_FROM else 0.0)
        return np.array(out)

    def wire(self, name: str, samples: int, value: Array) -> None:
        """Sample ``value`` into ``name_0``, older ones into ``name_1`` and so on."""
        for n in range(samples, 0, -1):
            self.sample[self.index[f"{name}_{n}"]] = self(**{f"{name}_{n - 1}": 1.0})
        self.sample[self.index[f"{name}_0"]] = value


def coupler(gains: tuple[float, float], depth: Array, speed: Array) -> Array:
    return gains[0] * depth + gains[1] * speed


def hand(lin: Linear, m: int, force: Array) -> Array:
    """Hand m under its coupler and its own push; returns the row of its estimated velocity."""
    up = 3.0 - 2.0 * m
    lin.mass(HAND, f"xh{m}", f"vh{m}", force + lin(one=up * SQUEEZE))
    lin.step[lin.index[f"xp{m}"]] = lin(**{f"xh{m}": 1.0})
    if m == 1:
        lin.push[lin.index["xh1"]] = 0.5 * T * T / HAND * EXTRA
        lin.push[lin.index["vh1"]] = T / HAND * EXTRA
    return lin(**{f"xh{m}": 1 / T, f"xp{m}": -1 / T})


def distributed_linear(delays: tuple[int, int]) -> Array:
    start: dict[str, float] = {}
    for m, n in zip((1, 2), delays, strict=True):
        x = START[m - 1]
        start |= {f"xh{m}": x, f"vh{m}": 0.0, f"xp{m}": x, f"xo{m}": 0.0, f"vo{m}": 0.0}
        start |= {f"{q}{m}_{i}": x if q == "hx" else 0.0 for i in range(n + 1) for q in HELD}
    lin = Linear(start)
    for m, r in ((1, 2), (2, 1)):
        up, late = 3.0 - 2.0 * m, delays[r - 1]
        estimate = lin(**{f"xh{m}": 1 / T, f"xp{m}": -1 / T})
        own = coupler(
            LOCAL,
            up * lin(**{f"xh{m}": 1.0, f"xo{m}": -1.0}) + lin(one=HALF),
            up * (estimate - lin(**{f"vo{m}": 1.0})),
        )
        other = coupler(
            REMOTE,
            -up * lin(**{f"hx{r}_{late}": 1.0, f"xo{m}": -1.0}) + lin(one=HALF),
            -up * lin(**{f"hv{r}_{late}": 1.0, f"vo{m}": -1.0}),
        )
        tie = coupler(
            COUPLING,
            lin(**{f"ox{r}_{late}": 1.0, f"xo{m}": -1.0}),
            lin(**{f"ov{r}_{late}": 1.0, f"vo{m}": -1.0}),
        )
        hand(lin, m, -up * own)
        lin.mass(MASS, f"xo{m}", f"vo{m}", up * own - up * other + tie)
        values = (lin(**{f"xh{m}": 1.0}), estimate, lin(**{f"xo{m}": 1.0}), lin(**{f"vo{m}": 1.0}))
        for name, value in zip(HELD, values, strict=True):
            lin.wire(f"{name}{m}", delays[m - 1], value)
    return lin.run(["xh1", "xh2", "xo1", "xo2"])


HELD = ("hx", "hv", "ox", "ov")


def centralized_linear(delays: tuple[int, int]) -> Array:
    up, down = delays
    start = {"xo": 0.0, "vo": 0.0}
    for m in (1, 2):
        start |= {f"xh{m}": START[m - 1], f"vh{m}": 0.0, f"xp{m}": START[m - 1]}
    start |= {f"hx_{i}": START[1] for i in range(up + 1)} | {f"hv_{i}": 0.0 for i in range(up + 1)}
    first = REMOTE[0] * (HALF - START[1])
    start |= {f"f_{i}": first for i in range(down + 1)}
    lin = Linear(start)
    speeds = [lin(**{f"xh{m}": 1 / T, f"xp{m}": -1 / T}) for m in (1, 2)]
    own = coupler(LOCAL, lin(xh1=1.0, xo=-1.0) + lin(one=HALF), speeds[0] - lin(vo=1.0))
    other = coupler(
        REMOTE,
        -lin(**{f"hx_{up}": 1.0, "xo": -1.0}) + lin(one=HALF),
        -lin(**{f"hv_{up}": 1.0, "vo": -1.0}),
    )
    hand(lin, 1, -own)
    hand(lin, 2, lin(**{f"f_{down}": 1.0}))
    lin.mass(MASS, "xo", "vo", own - other)
    lin.wire("hx", up, lin(xh2=1.0))
    lin.wire("hv", up, speeds[1])
    # The force is computed from what has just been delivered, so its row follows the other wires.
    lin.wire("f", down, other @ lin.sample)
    return lin.run(["xh1", "xh2", "xo"])


@pytest.mark.parametrize("delays", [(0, 0), (1, 0), (1, 1), (2, 1)])
def test_distributed_chain(delays: tuple[int, int]) -> None:
    models, linear = distributed_models(delays), distributed_linear(delays)
    assert np.ptp(models[:, 2]) > 1e-3
    np.testing.assert_allclose(models, linear, rtol=0, atol=TOLERANCE)


@pytest.mark.parametrize("delays", [(0, 0), (1, 0), (0, 1)])
def test_centralized_chain(delays: tuple[int, int]) -> None:
    models, linear = centralized_models(delays), centralized_linear(delays)
    assert np.ptp(models[:, 2]) > 1e-3
    np.testing.assert_allclose(models, linear, rtol=0, atol=TOLERANCE)
