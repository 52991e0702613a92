"""Chapters 3 and 4: one user, and how the page reads the equations."""
# ruff: noqa: E501  (rows of Markdown tables cannot be broken)

from __future__ import annotations

from cosim.theory.chapters.page.numbers import Row, limits, table, timing


def chapter_3() -> str:
    """The chapter as Markdown."""
    rows: list[Row] = []
    for damping in (10, 15):
        for late in (0, 1):
            found = limits("single", {"b": damping}, "k", timing(ratio=1, computation_delay=late))
            law = f"2b/T_c = {2 * damping * 1024}" if late == 0 else "–"
            rows.append((str(damping), "z⁻¹" if late else "none", law, f"{found[0][1]:.5g}"))
    return f"""
## Chapter 3: one user

The chapter prints no number. (3.14)–(3.18) give the closed loop; its largest stable stiffness:

{table(("b (N·s/m)", "computation delay", "closed form (N/m)", "computed (N/m)"), rows)}

Two slips: D in (3.18) is 4 × 1, and (3.19) means A_D^C, the closed loop. A single user with a free
object conserves momentum, so λ = 1 is double there.
"""


CHAPTER_4 = """
## Chapter 4: modelling

The constants: T_c = 1/1024 s, T_t = 1/128 s, N = 8. Both routes of the chapter are here
(`cosim.theory.models.frame` resamples subsystems, 4.2.1; `cosim.theory.models.lifting` lifts directly, 4.2.2 and
appendix A, for several rates and any rational ratio), and a third that forms no matrix and only
simulates (`cosim.theory.models.monodromy`). Their nonzero eigenvalues agree to 1e-10 over random
parameters, users, delays and ratios; so do co-simulated runs of the scenarios.
Where the ratio is not whole, a network sample falls between two control ticks: the appendix samples
the bodies right then, the master and every real device send what they knew at the last tick. Both are
here (`--sampling`), and the latter is the default, because it is what runs: at N = 32/3 and n = 1 it
takes k_12max of Fig. 5.2 (k_11 = 2000) from 1477 to 1364 N/m.

| equation | printed | read as |
|---|---|---|
| (4.8) | B_tr(:, 2:3), B_tr(2, :), B_tr(1, :) | B_tr(:, 2) for the force received, B_tr(:, 1) for the user's |
| (4.11) | the distributed loop | holds for n = 0 only; delays enter by (4.6) |
| (4.13), (4.14) | missing from the text | the masses of Figs 4.3 and 4.4 side by side |
| (4.17), (A.4), (A.5) | N_i for two things | the period in base ticks, and the samples per frame |
| (4.21) | x̃ holds x_D(k + 1) | x̃ holds x_D(k) |
| (4.26), third line | K_2 (X_h1 + X_o) | K_2 (X_h2 + X_o); literally ρ = 1.247 at n = 0 with Table 6.1 |
| (4.30) | all eigenvalues inside | all but the neutral ones |
| (A.7) | repeats (A.4) | nothing |
"""
