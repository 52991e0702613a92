"""What the commands say of whatever comes to a scenario's packets, and of the kernel beside it."""

from __future__ import annotations

from typing import Any

from cosim.analysis.answers.orders import RunOrders
from cosim.cli.theory.robust.joint import sentence
from cosim.theory.robust.joint_radius import JointRadius


def joint_result(orders: RunOrders, found: JointRadius, growth: float) -> dict[str, Any]:
    """The JSON object."""
    return {
        "verdict": found.verdict,
        "lower": found.lower,
        "upper": found.upper,
        "quadratic": found.quadratic,
        "worst": worst(orders, found),
        "kernel_growth": growth,
        "maps": len(orders.maps.outcomes),
        "nodes": orders.nodes,
        "links": list(orders.links),
    }


def worst(orders: RunOrders, found: JointRadius) -> list[list[list[float]]]:
    """What comes, period after period: per link the delays (samples) of the packets that arrive."""
    period = orders.point.run.hyperperiod
    return [
        [
            [age + tick / period for tick, age in fate.arrivals]
            for fate in orders.maps.outcomes[number]
        ]
        for number in found.word
    ]


def joint_lines(orders: RunOrders, found: JointRadius, growth: float) -> list[str]:
    """The bounds and the word, for people."""
    order = " → ".join(
        f"({', '.join(_said(packets) for packets in period)})" for period in worst(orders, found)
    )
    links = ", ".join(orders.links)
    return [
        sentence(found),
        f"largest known growth: {order}, repeated (delay of what arrives on {links})",
        f"the kernel with these packets: {growth:.6f} per network period",
    ]


def _said(packets: list[float]) -> str:
    return " and ".join(f"{delay:g}" for delay in packets) or "nothing"
