"""With a deadband a packet's content is renewed only where somebody could feel the difference."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.physics.planar_oracle import Bench, T

K, LEAST, RATIO = 0.1, 0.2, 8
STIFFNESS, DAMPING = 170.0, 3.0
"""Of the server's coupler, as the client has them by default."""


def sweep(deadband: float, **parameters: float) -> tuple[list[dict], Bench]:
    """A client's finger that swings and rests; its packet at every network sample."""
    bench = Bench("remote_client", [(0.0, 0.0)], deadband=deadband, **parameters)
    packets = []
    for tick in range(1599):
        swing = 0.01 * np.sin(0.01 * min(tick, 800))
        bench.put((swing, 0.0))
        if tick % RATIO == 0:
            packets.append(
                {
                    "tick": tick,
                    "position": bench["up.finger_1_position"],
                    "velocity": bench["up.finger_1_velocity"],
                    "true_position": bench["finger_1.position"],
                    "true_velocity": bench["finger_1.velocity"],
                    "age": bench["up.source_age"],
                    "source_tick": bench["up.source_tick"],
                }
            )
        bench.step()
    return packets, bench


def test_without_a_deadband_every_packet_is_new() -> None:
    packets, bench = sweep(0.0)
    assert all(np.array_equal(p["position"], p["true_position"]) for p in packets)
    assert all(p["age"] == 0 for p in packets)
    assert bench["packets_due"] == bench["packets_sent"] == len(packets)


@pytest.mark.parametrize("longest", [4, 1000])
def test_content_is_never_off_by_more_than_the_deadband(longest: int) -> None:
    packets, bench = sweep(K, deadband_longest=longest)
    for p in packets:
        moved = np.subtract(p["true_position"], p["position"])
        faster = np.subtract(p["true_velocity"], p["velocity"])
        # A free hand feels nothing, so that the fraction is of the least force.
        assert np.linalg.norm(STIFFNESS * moved + DAMPING * faster) <= K * LEAST * (1 + 1e-9)
        assert p["source_tick"] == p["tick"]
        assert p["age"] < longest * RATIO
    renewed = sum(p["age"] == 0 for p in packets)
    assert bench["packets_sent"] == renewed
    assert bench["packets_due"] == len(packets)
    assert renewed < 0.9 * len(packets)


def test_a_millionth_and_a_hundred_are_no_tenth() -> None:
    counts = [sweep(k, deadband_longest=1000)[1]["packets_sent"] for k in (1e-6, K, 100.0)]
    assert counts[0] > counts[1] > counts[2]


def test_prediction_saves_more() -> None:
    """A receiver that moves positions on lets the position rest while the speed is steady."""

    def sent(predictor: int) -> int:
        bench = Bench(
            "distributed_workstation",
            [(0.5, 0.5)],
            deadband=K,
            deadband_longest=1000,
            predictor=predictor,
        )
        for tick in range(800):
            bench.put((0.5 + 0.02 * tick * T, 0.5))
            bench.step()
        return bench["packets_sent"]

    assert sent(1) < 0.2 * sent(0)


def test_forces_of_the_server_follow_webers_law() -> None:
    bench = Bench("central_server", [(0.5, 0.5)], deadband=K, deadband_longest=1000, mass=1e9)
    bench.put((0.5, 0.5))
    bench["client_1.source_tick"], bench["client_1.status"] = 0, 32
    sent = []
    for tick in range(799):
        depth = 0.001 + 5e-6 * tick
        bench["client_1.finger_1_position"] = (0.0, 0.05 - depth)
        if tick % RATIO == 0:
            shown, true = bench["to_client_1.finger_1_force"][1], 170 * depth
            assert abs(true - shown) <= K * max(shown, LEAST) * (1 + 1e-9)
            sent.append(shown)
        bench.step()
    renewed = len(set(sent))
    assert bench["packets_sent"] == renewed
    # From 0.17 N to 0.85 N in steps of a tenth, or of 0.02 N below 0.2 N.
    assert 12 <= renewed <= 20


@pytest.mark.parametrize("model", ["remote_client", "distributed_workstation", "central_server"])
def test_a_packet_says_whether_its_content_is_repeated(model: str) -> None:
    name = {"remote_client": "up", "central_server": "to_client_1"}.get(model, "shared")
    for deadband in (0.0, K):
        bench = Bench(model, [(0.5, 0.5)], deadband=deadband, deadband_longest=4)
        repeated = []
        for tick in range(10 * RATIO):
            bench.put((0.5, 0.5))
            if tick % RATIO == 0:
                repeated.append(bool(bench[f"{name}.status"] & 128))
                assert repeated[-1] == (bench[f"{name}.source_age"] > 0)
            bench.step()
        if deadband == 0.0:
            assert not any(repeated)
        else:
            assert repeated == [number % 4 != 0 for number in range(10)]
