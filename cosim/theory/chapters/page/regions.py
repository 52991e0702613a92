"""Chapter 5: points of each figure, and what the thesis says about them."""
# ruff: noqa: E501  (rows of Markdown tables cannot be broken)

from __future__ import annotations

from cosim.theory.chapters.page.numbers import Row, digits, highest, limits, table, timing
from cosim.theory.models.parameters import Architecture

_FIGURE_POINTS: tuple[tuple[str, str, Architecture, dict[str, float], str], ...] = (
    ("5.1", "k_1 = 1000", "centralized", {"k_1": 1000.0}, "k_2"),
    ("5.1", "k_1 = 1000, b_2 = 3", "centralized", {"k_1": 1000.0, "b_2": 3.0}, "k_2"),
    ("5.2", "k_11 = 2000, k_o = 1000", "distributed", {"k_11": 2000.0}, "k_12"),
    ("5.3", "k_11 = 2000, k_12 = 300", "distributed", {"k_11": 2000.0}, "k_o"),
    ("5.4", "k_o = 1000, k_11 = 2000", "distributed", {"k_o": 1000.0}, "k_12"),
)


def chapter_5() -> str:
    """The chapter as Markdown."""
    points: list[Row] = []
    for number, fixed, architecture, given, vary in _FIGURE_POINTS:
        found = [highest(limits(architecture, given, vary, timing(n))) for n in range(4)]
        points.append((number, fixed, vary, *found))
    local = [
        highest(limits("centralized", {"k_2": 50.0, "b_2": 3.0}, "k_1", timing(n)))
        for n in range(4)
    ]
    alone = highest(limits("single", {}, "k", timing(ratio=1)))
    again = limits("distributed", {"k_12": 1000.0}, "k_11", timing(3))
    spans = " and ".join(f"[{digits(low)}, {digits(high, 5)}]" for low, high in again)
    return f"""
## Chapter 5: stability

m_h = 0.1 kg, m_o = 0.4 kg, b = 10 N·s/m for every coupler, N = 8, as printed.

![Figure 5.1](images/theory/figure_5_1.png)
![Figure 5.2](images/theory/figure_5_2.png)
![Figure 5.3](images/theory/figure_5_3.png)
![Figure 5.4](images/theory/figure_5_4.png)

One point of each figure: the largest stable stiffness in N/m ("–": no stable value).

{table(("figure", "fixed", "largest", "n = 0", "1", "2", "3"), points)}

What the thesis says about them, and what is computed:

| printed | computed |
|---|---|
| at n = 0 the packet rate alone reduces the margin for k_2 | {alone} N/m for a user without a network in between, {points[0][3]} N/m for k_2 |
| k_2 decreases further as n grows | yes; at b_2 = 10 nothing at all is stable at n = 2 and 3, with b_2 = 3 the row above |
| the local user is unaffected by the delay | yes: with k_2 = 50, b_2 = 3 the largest k_1 is {", ".join(local)} N/m at n = 0 to 3 |
| the distributed region (Fig. 5.2) is noticeably larger | yes: {points[2][4]} against {points[0][4]} N/m at n = 1 |
| the delay reduces the marginal k_o and k_12 | yes, in every row |

The regions are re-entrant: at k_12 = 1000 N/m and n = 3, k_11 is stable in {spans} N/m
(looked for from 1 N/m up). Bisection from zero would miss the second part; `theory boundary` finds both.
"""
