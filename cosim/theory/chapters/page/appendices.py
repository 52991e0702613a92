"""Appendices A and B: the closed forms beside the lifted model."""
# ruff: noqa: E501  (rows of Markdown tables cannot be broken)

from __future__ import annotations

from cosim.theory.chapters.page.numbers import Row, damping_felt, table
from cosim.theory.transparency.damping import (
    centralized_damping_two_samples,
    original_damping_two_samples,
)


def appendices() -> str:
    """What is printed and computed, as Markdown."""
    rows: list[Row] = [
        (
            "(B.10), centralized, any n",
            f"{centralized_damping_two_samples(0.4, 85.0, 3.0, 1 / 1024):.6f}",
            ", ".join(f"{damping_felt('centralized', n, 2):.6f}" for n in range(3))
            + " at n = 0, 1, 2",
        ),
        (
            "(B.11)–(B.13), distributed",
            f"{_closed_b_11():.7f}",
            f"{damping_felt('distributed', 1, 2):.7f} at n = 1; {damping_felt('distributed', 0, 2):.4f} at n = 0",
        ),
    ]
    return f"""
## Appendices A and B

Appendix A is `cosim.theory.models.lifting`, with the readings listed under chapter 4. Appendix B (which
section 6.1 calls C), N = 2, Table 6.1, N·s/m:

{table(("formula", "closed form", "computed"), rows)}

(B.11)–(B.13) are exact, but for one sample of round-trip delay, not for n = 0 as the appendix says;
a test proves the identity in rational arithmetic at random points. In (B.12) M_o is m_o and T_o is
T_c.
"""


def _closed_b_11() -> float:
    return float(
        original_damping_two_samples(
            T_c=1 / 1024, m_1=0.1, m_o=0.4, k_11=3000, b_11=20, k_12=400, b_12=2, k_o=300, b_o=10
        )
    )
