"""The predictor in C against the one that is fitted, packet by packet and tick by tick."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cosim.analysis.intent.filter import Tuning, beliefs
from cosim.analysis.intent.moves import QUICK, Moves, made
from tests.support.physics.planar_oracle import Array, Bench

K, B, RATIO = 100.0, 7.0, 8
TUNING = Tuning.default()


def heavy(**parameters: Any) -> Bench:
    """A copy of the box that stays where it is, pulled at by its peer's copy alone."""
    bench = Bench(
        "distributed_workstation",
        [(0.5, 0.5)],
        mass=1e9,
        inertia=1e9,
        coupling_stiffness=K,
        coupling_damping=B,
        ground_friction=0.0,
        predictor=2,
        **parameters,
    )
    bench.put((0.5, 0.5))
    return bench


def pulled(moves: Moves, lost: frozenset[int] = frozenset(), **parameters: Any) -> Array:
    """K x + B v of the guessed copy at every tick, in N; packets arrive two samples late."""
    bench, found = heavy(**parameters), np.zeros(len(moves.position))
    late = 2 * RATIO
    for tick in range(len(found)):
        sent = tick - late
        if sent >= 0 and sent % RATIO == 0 and sent // RATIO not in lost:
            bench["peer_1.source_tick"] = sent
            bench["peer_1.box_x"] = moves.position[sent, 0]
            bench["peer_1.box_vx"] = moves.velocity[sent, 0]
        found[tick] = bench["coupling_wrench.x"]
        bench.step()
    return found


def test_every_tick_is_what_the_filter_says() -> None:
    moves = made(QUICK, tracks=1, length=0.75)
    found = pulled(moves)
    heard = beliefs(TUNING, moves.position[::RATIO], moves.velocity[::RATIO], RATIO * moves.period)
    for tick in range(2 * RATIO, len(found)):
        packet, since = divmod(tick - 2 * RATIO, RATIO)
        x, v = heard.ahead(TUNING, (2 * RATIO + since) * moves.period)
        want = K * x[packet, 0] + B * v[packet, 0]
        assert found[tick] == pytest.approx(want, rel=1e-7, abs=1e-9), tick
    assert heard.moving.min() < 0.2
    assert heard.moving.max() > 0.9


def test_a_lost_packet_is_bridged_over_its_time() -> None:
    """Between packets the guess goes on; the next one is heard with the longer step."""
    moves = made(QUICK, tracks=1, length=0.75)
    gaps = frozenset({40, 41, 60})
    whole, holes = pulled(moves), pulled(moves, gaps)
    assert holes[: 42 * RATIO] == pytest.approx(whole[: 42 * RATIO], abs=1e-12)
    off = np.abs(holes - whole)
    assert off.max() > 1e-3
    assert off[70 * RATIO :].max() < 0.2 * K * np.ptp(moves.position)


def test_a_peer_that_does_not_count_is_forgotten() -> None:
    moves = made(QUICK, tracks=1, length=0.5)
    bench = heavy()
    for tick in range(0, 40 * RATIO, RATIO):
        bench["peer_1.source_tick"] = tick
        bench["peer_1.box_x"] = moves.position[tick, 0]
        bench["peer_1.box_vx"] = moves.velocity[tick, 0]
        bench.step()
    bench["peer_valid[1]"] = False
    bench.step()
    bench["peer_valid[1]"] = True
    bench["peer_1.box_x"], bench["peer_1.box_vx"] = 0.03, 0.0
    bench["peer_age[1]"] = 1
    assert bench["coupling_wrench.x"] == pytest.approx(K * 0.03, rel=1e-9)


def test_a_deadband_beside_it_is_refused() -> None:
    with pytest.raises(Exception, match="do not go together"):
        heavy(deadband=0.1)


def test_a_number_that_no_filter_can_have_is_refused() -> None:
    with pytest.raises(Exception, match="have to be above 0"):
        heavy(**{"intent.decay": 0.0})
