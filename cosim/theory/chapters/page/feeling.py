"""Chapter 6: admittance, damping, compensation and stiffness beside what is printed."""
# ruff: noqa: E501  (rows of Markdown tables cannot be broken)

from __future__ import annotations

import numpy as np

from cosim.theory.chapters.chapter_6 import FIGURES as ADMITTANCE_FIGURES
from cosim.theory.chapters.chapter_6 import table_6_1, table_6_2
from cosim.theory.chapters.page.numbers import (
    Row,
    damping_felt,
    digits,
    one_hand,
    signed,
    table,
    timing,
)
from cosim.theory.models.parameters import TABLE_6_1, WALL, Parameters
from cosim.theory.stability.spectral_radius import stability
from cosim.theory.transparency.compensation import null_compensation
from cosim.theory.transparency.damping import (
    distributed_damping_two_samples,
    uniform_compensation,
)
from cosim.theory.transparency.stiffness import distributed_stiffness, equivalent_stiffness


def chapter_6() -> str:
    """The chapter as Markdown."""
    parameters = [
        (str(r["architecture"]), str(r["parameter"]), f"{r['value']:g} {r['unit']}")
        for r in table_6_1()
    ]
    damping: list[Row] = [
        (
            f"{row['architecture']}, {row['model']}",
            str(row["thesis"]),
            f"{row['damping']:.4g}",
            _WHY[str(row["architecture"]), str(row["model"])].format(
                two=damping_felt("centralized", ratio=2),
                stiff=damping_felt("distributed", kind="simplified", k_o=400.0),
            ),
        )
        for row in table_6_2()
    ]
    nulls: list[Row] = []
    model, _ = one_hand("distributed")
    for n in range(3):
        found = null_compensation(model, timing(n), 0)
        nulls.append(
            (
                str(n),
                f"{found.damping:.3f}",
                signed(found.value),
                f"{found.compensated.spectral_radius:.4f}",
                f"{stability(uniform_compensation(model, -3.0), timing(n)).spectral_radius:.4f}",
            )
        )
    felt = _admittances()
    wall = Parameters("distributed", WALL, TABLE_6_1["distributed"]).model((True, False))
    remote = Parameters("centralized", WALL, TABLE_6_1["centralized"])
    closed = distributed_stiffness(3000.0, 400.0, 300.0, WALL["k_w"])
    stiffness: list[Row] = [
        ("ideal", "k_w", f"{WALL['k_w']:.6g}", ""),
        (
            "remote",
            "1/k_eq = (k_2 + k_w)/(k_w k_2)",
            f"{equivalent_stiffness(remote.model((False, True)), 1):.4g}",
            "as printed",
        ),
        (
            "local",
            "–",
            f"{equivalent_stiffness(remote.model((True, False)), 0):.5g}",
            "k_1 in series with k_w",
        ),
        (
            "distributed",
            f"(6.4): {closed.as_printed:.2f}",
            f"{equivalent_stiffness(wall, 0):.2f}",
            "the 2 k_o² terms of (6.4) are a sign slip: they cancel",
        ),
    ]
    closed_6_3 = distributed_damping_two_samples(0.4, 300.0, 10.0, 1 / 1024)
    lifted_6_3 = damping_felt("distributed", ratio=2, kind="simplified")
    slower = distributed_damping_two_samples(0.4, 300.0, 10.0, 1 / 512)
    tighter = distributed_damping_two_samples(0.4, 400.0, 10.0, 1 / 1024)
    return f"""
## Chapter 6: transparency

### Table 6.1

{table(("architecture", "parameter", "value"), parameters)}

As printed, with N·s/m where the table has N/s/m; k_21 stands for k_12 too. Defaults of
`damping`, `stiffness` and `admittance`.

### Figures 6.2, 6.4 and 6.5

![Figure 6.2](images/theory/figure_6_2.png)
![Figure 6.4](images/theory/figure_6_4.png)
![Figure 6.5](images/theory/figure_6_5.png)

Drawn by both definitions: *frame-lifted* is (6.1), the force held over T_t and the velocity read at
the start of the frame; *fundamental* lets the force change at T_c and takes the harmonic at its own
frequency. They part above about 50 rad/s, where only the second is what a hand feels. The ideal is
hand and object as one rigid mass of 0.5 kg. At n = 1, fundamental:

{table(("who", "case", *(f"{w:g} rad/s" for w in _FREQUENCIES), "unit"), felt)}

| printed | computed |
|---|---|
| the local user observes the closest admittance to the virtual mass | yes, up to about 50 rad/s; at 100 rad/s the distributed user is nearer to it |
| at high frequencies the local response deviates from a mass | yes: {felt[1][5]} against {felt[0][5]} m/(N·s) at 100 rad/s |
| the remote user of the centralized loop deviates most at medium to high frequencies | yes: {felt[2][5]} m/(N·s) at 100 rad/s |
| at low frequencies the remote and the distributed user feel a damper | yes: at 0.01 rad/s {felt[2][2]} and {felt[3][2]} m/(N·s), which is 1/b of (6.2) |
| after compensation the admittance is close to the mass over a wide range | the damping is gone, but the slope is that of a mass of about 0.74 kg, not 0.5: the inertia stays nearer to that of two copies |
| in contact the low-frequency magnitude is close to 1/k_2, 1/k_11 and 1/k_w | yes, see the stiffness below |

### Damping (6.2), (6.3)

(6.3), N = 2, n = 0, k_o = 300, b_o = 10: {closed_6_3:.6f} N·s/m in closed form and
{lifted_6_3:.6f} from the lifted model; the force acts on both copies and the velocity is read at
the start of the frame. It grows as the control rate falls (at 512 Hz: {slower:.4f}) and as k_o is
tightened (at 400 N/m: {tighter:.4f}), as the thesis says.

### Table 6.2

Damping in N·s/m at n = 0, one user holding the object:

{table(("", "printed", "computed, N = 8", "why they differ"), damping)}

### Compensation

Distributed, one user holding the object, b_c in N·s/m on each copy:

{table(("n", "damping felt", "b_c that nulls it", "ρ with it", "ρ with the thesis's −3"), nulls)}

The thesis uses b_o = −3 N·s/m, "obtained using n = 1": the null at n = 1 is
{nulls[1][2]}. It recommends the value of n = 0 where n is not known, because that always
under-compensates, which the table confirms; −3 at a true n of 0 is unstable (ρ = {nulls[0][4]}, b_c
sampled at T_c and held). ρ with the exact null is that of the rest: the common velocity is neutral.

### Stiffness in rigid contact (6.4), (6.5)

k_w = 30000 N/m:

{table(("who", "printed", "computed (N/m)", "remark"), stiffness)}
"""


_WHY = {
    ("centralized", "original"): (
        "the caption says N = 8; 0.04 is the value of (B.10) at N = 2, where we compute {two:.4f}"
    ),
    ("centralized", "simplified"): "",
    ("distributed", "original"): "3 % apart, not explained",
    ("distributed", "simplified"): (
        "not explained by Table 6.1; k_o = 400 N/m would give {stiff:.4g}"
    ),
}
_FREQUENCIES = (0.01, 1.0, 10.0, 100.0)


def _admittance(value: float) -> str:
    return digits(value) if value >= 1e-3 else f"{value * 1e6:.4g}e-6"


def _admittances() -> list[Row]:
    rows: list[Row] = []
    seen: set[tuple[str, str]] = set()
    for figure in ADMITTANCE_FIGURES.values():
        unit = "m/(N·s)" if figure.case == "free" else "m/N"
        for felt, response in figure.responses(np.array(_FREQUENCIES)).items():
            if (felt, figure.case) in seen:
                continue
            seen.add((felt, figure.case))
            magnitudes = (
                _admittance(float(magnitude)) for magnitude in np.abs(response.fundamental)
            )
            rows.append((felt, figure.case, *magnitudes, unit))
    return rows
