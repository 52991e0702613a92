"""Designs at random networks, written down before the search learned to prove stability early."""

from __future__ import annotations

from fractions import Fraction

import pytest

from cosim.theory.chance.network import Network
from cosim.theory.design.search import design
from cosim.theory.models.parameters import CHAPTER_5, Architecture, Parameters

Asked = tuple[Architecture, int, float, float, float, float]
"""Architecture, network rate (Hz), delay, jitter (s), loss and margin."""

WRITTEN: list[tuple[Asked, dict[str, float], tuple[float, str, float]]] = [
    (
        ("distributed", 128, 0.013975, 0.002368, 0.001, 0.25),
        {
            "k_11": 12130.560000000001,
            "k_12": 327.52512,
            "k_o": 303.264,
            "b_11": 10.0,
            "b_12": 5.859375,
            "b_o": 7.8125,
        },
        (-1.8167405005588007, "stiffness +25 %, damping −25 %", 0.9994895385399712),
    ),
    (
        ("distributed", 64, 0.017413, 0.0, 0.05, 0.1),
        {
            "k_11": 14945.472000000002,
            "k_12": 235.33738030080008,
            "k_o": 131.14651680000003,
            "b_11": 10.0,
            "b_12": 4.6875,
            "b_o": 9.765625,
        },
        (-0.8326611034917303, "a sample of delay more", 0.9994201463678823),
    ),
    (
        ("centralized", 64, 0.017868, 0.006877, 0.001, 0.1),
        {
            "k_1": 9074.289790425602,
            "k_2": 8.533403304075001,
            "b_1": 8.889963586709147,
            "b_2": 1.365498406918525,
        },
        (0.0, "a sample of delay more", 0.9990333421498426),
    ),
    (
        ("distributed", 512, 0.002365, 0.000125, 0.05, 0.25),
        {
            "k_11": 11232.0,
            "k_12": 1310.10048,
            "k_o": 1213.056,
            "b_11": 10.0,
            "b_12": 5.859375,
            "b_o": 7.8125,
        },
        (-2.3657300015463356, "stiffness +25 %, damping −25 %", 0.9998770874559991),
    ),
    (
        ("centralized", 128, 0.015545, 0.000623, 0.01, 0.1),
        {
            "k_1": 16212.130642944005,
            "k_2": 33.984083250000005,
            "b_1": 12.019230769230768,
            "b_2": 2.3076923076923075,
        },
        (0.0, "loss and jitter, stiffness and damping +10 %", 0.9998787645903543),
    ),
    (
        ("distributed", 512, 0.003132, 0.000985, 0.05, 0.25),
        {
            "k_11": 11232.0,
            "k_12": 1310.10048,
            "k_o": 1213.056,
            "b_11": 10.0,
            "b_12": 5.859375,
            "b_o": 7.8125,
        },
        (-2.3808523332365312, "stiffness +25 %, damping −25 %", 0.99990684698783),
    ),
    (
        ("distributed", 1024, 0.001319, 0.0, 0.0, 0.1),
        {
            "k_11": 16000.0,
            "k_12": 3406.2612480000007,
            "k_o": 4852.224,
            "b_11": 10.0,
            "b_12": 5.859375,
            "b_o": 12.20703125,
        },
        (-3.7309987971872713, "stiffness +10 %, damping −10 %", 0.9998771705055916),
    ),
    (
        ("centralized", 512, 0.001688, 0.000112, 0.05, 0.1),
        {"k_1": 24367.868928000007, "k_2": 678.9744000000001, "b_1": 15.625, "b_2": 4.6875},
        (0.0, "stiffness −10 %, damping −10 %", 0.9990266331403123),
    ),
    (
        ("distributed", 256, 0.005809, 0.00109, 0.01, 0.25),
        {
            "k_11": 12130.560000000001,
            "k_12": 655.05024,
            "k_o": 788.4864000000001,
            "b_11": 10.0,
            "b_12": 7.32421875,
            "b_o": 7.8125,
        },
        (-2.236850829862598, "stiffness +25 %, damping −25 %", 0.9998697460616622),
    ),
    (
        ("centralized", 1024, 0.001703, 0.0, 0.0, 0.1),
        {"k_1": 26202.009600000005, "k_2": 788.4864000000001, "b_1": 15.625, "b_2": 4.6875},
        (0.0, "stiffness +10 %, damping −10 %", 0.9991661821963489),
    ),
    (
        ("distributed", 512, 0.001092, 0.0004, 0.0, 0.25),
        {
            "k_11": 11232.0,
            "k_12": 2176.7823360000007,
            "k_o": 1576.9728000000002,
            "b_11": 10.0,
            "b_12": 4.6875,
            "b_o": 7.8125,
        },
        (-1.6140297285688947, "stiffness +25 %, damping −25 %", 0.9999664460768669),
    ),
    (
        ("centralized", 256, 1.5e-05, 0.001096, 0.0, 0.1),
        {"k_1": 22662.118103040008, "k_2": 242.86392, "b_1": 15.625, "b_2": 3.75},
        (0.0, "stiffness −10 %, damping +10 %", 0.9979172920425008),
    ),
]


@pytest.mark.parametrize(("asked", "gains", "rest"), WRITTEN)
def test_a_design_is_what_it_was(
    asked: Asked, gains: dict[str, float], rest: tuple[float, str, float]
) -> None:
    architecture, rate, delay, jitter, loss, margin = asked
    compensation, worst, radius = rest
    network = Network(Fraction(1, rate), delay, jitter, loss)
    parameters = Parameters(architecture, {}, CHAPTER_5[architecture], 2)
    found = design(parameters, network, Fraction(1, 1024), margin)
    assert found.gains == pytest.approx(gains, rel=1e-12)
    assert found.compensation == pytest.approx(compensation, rel=1e-9)
    assert found.worst == worst
    assert found.corners[worst] == pytest.approx(radius, abs=1e-9)
