"""What the sweeps past the thesis found, in sentences with the measured numbers in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from cosim.thesis.claims.verdict import Decided
from cosim.thesis.sweeps.beyond import Beyond
from cosim.thesis.sweeps.breaking import Limit
from cosim.thesis.sweeps.free_motions import DELAYS


@dataclass(frozen=True, slots=True)
class Finding:
    """A figure with what it shows; ``image`` is a URL."""

    title: str
    text: tuple[str, ...]
    caption: str
    image: str


@dataclass(frozen=True, slots=True)
class BeyondPart:
    """The page's second part: statements with scenarios of their own, and the sweeps' figures."""

    decided: Sequence[Decided]
    found: Beyond
    figures: Mapping[str, Path]

    def findings(self, url: Callable[[Path], str]) -> tuple[Finding, ...]:
        """The figures that were drawn, with their sentences."""
        return tuple(
            Finding(title, text(self.found), caption, url(self.figures[name]))
            for name, (title, text, caption) in FINDINGS.items()
            if name in self.figures
        )


def _breaking(found: Beyond) -> tuple[str, ...]:
    stiffness = found.limits["stiffness"]
    jitter = found.limits["jitter"]
    loss = found.limits["centralized_loss"]
    distributed = found.limits["distributed_loss"]
    return (
        (
            "Centralized, the stiffest remote couplers that hold fall from "
            f"{_range(stiffness[0])} N/m at n = {stiffness[0].delay} to {_range(stiffness[-1])} "
            f"N/m at n = {stiffness[-1].delay}; the theory has {_predictions(stiffness)} N/m. "
            "Jitter alone does the same: where each packet is late by 0 to 3 samples, mean-square "
            f"theory has {_predictions(jitter[-1:])} N/m and simulation {_range(jitter[-1])} N/m. "
            "With the soft couplers of section 8.2, loss breaks the grasp at "
            f"{_predictions(loss)} by mean-square theory and between {_ranges(loss)} in "
            "simulation. At n = 3 it is lost without any loss."
        ),
        (
            "The theory takes the grasp apart into four single-axis modes (squeeze, carry, "
            "lift, turn) with the relaxed hand's 100 N/m and 3 N·s/m; the first to become "
            "unstable is lift, two fingers and the box along the faces. It has no encoders, no "
            "velocity estimator and no friction. The estimator's delay takes damping away, so "
            "that the simulation breaks a little earlier at n = 1 and 2; the joints' friction "
            "(0.04 N at the tip) and a trial of 2.5 s, in which what grows slowly stays small, "
            "let it hold a little longer at n = 3 and 4. Under loss, a mean square can grow "
            "although almost every single run decays, and a short run need not meet the burst that "
            "breaks it: theory may lie below simulation there, too."
        ),
        (
            "Distributed, the theory finds no loss below 0.999 that destabilises the grasp: "
            "the local contact is simulated without the network, and what is held from the "
            f"others only pulls. In simulation it breaks between {_ranges(distributed)}, and "
            "not by growing: at such loss the last packet is so old that the carried box "
            "leaves a remote finger, which presses on the copy with a fraction of a newton, "
            "and that contact ends. That is a limit of tracking, which no analysis of "
            "stability sees."
        ),
    )


def _realism(found: Beyond) -> tuple[str, ...]:
    built, ideal = found.realism["as built"], found.realism["all ideal"]
    ripple = {name: 1e3 * motion.ripple for name, motion in found.realism.items()}
    return (
        (
            f"The free motion of figure 8.3 takes {built.net_force:.3f} N with everything on "
            f"and {ideal.net_force:.3f} N with everything ideal: what the devices cost is not "
            f"amplitude but ripple, {ripple['as built']:.0f} mN rms against "
            f"{ripple['all ideal']:.1f} mN. Without friction in the joints "
            f"{ripple['no friction in the joints']:.0f} mN are left, with ideal encoders "
            f"{ripple['ideal encoders']:.0f} mN. 16 bits of DAC and 2 kHz of amplifier cost "
            "less than 1 mN each. The plain difference over one tick in place of first-order "
            f"adaptive windowing makes it {ripple['velocity: difference over 1 tick']:.0f} mN."
        ),
    )


def _prediction(found: Beyond) -> tuple[str, ...]:
    def listed(predictor: str) -> str:
        return ", ".join(f"{found.predictors[predictor, n].net_force:.3f}" for n in DELAYS)

    held = found.predictors["hold_last", DELAYS[-1]]
    linear = found.predictors["linear", DELAYS[-1]]
    return (
        (
            "A remote finger and copy that are moved on with their last velocity for their age "
            "take away most of the damping that the delay adds: the net force is "
            f"{listed('linear')} N at n = {', '.join(map(str, DELAYS))} in place of "
            f"{listed('hold_last')} N. It costs ripple, {1e3 * linear.ripple:.0f} mN rms in "
            f"place of {1e3 * held.ripple:.0f} mN at n = {DELAYS[-1]}, because the velocity's "
            "noise is multiplied by the age. The drift between the copies, "
            f"{1e3 * held.drift:.1f} and {1e3 * linear.drift:.1f} mm rms, hardly changes: it is "
            "the leaning force on the springs between them."
        ),
    )


def _users(found: Beyond) -> tuple[str, ...]:
    at_one = ", ".join(f"{radii[1]:.3f} for {users}" for users, radii in found.radii.items())
    return (
        (
            f"At n = 1 the spectral radius is {at_one} users: with the couplers of two, more "
            "users bring more damping between the copies, and stability is not what limits "
            "their number. The single axis has one finger a user, all of them pressing along "
            "it."
        ),
    )


FINDINGS: dict[str, tuple[str, Callable[[Beyond], tuple[str, ...]], str]] = {
    "breaking": (
        "Where the grasp breaks",
        _breaking,
        (
            "Lines: theory. Points: simulation of the grasp and carry, from the largest value "
            "that held to the smallest that did not; it is broken where a contact is lost or a "
            "force ripples by more than 0.5 N rms."
        ),
    ),
    "realism": (
        "What realism costs",
        _realism,
        (
            "The free motion of figure 8.3 at n = 1, uncompensated, with one thing at a time "
            "made ideal; ripple is what is left of the net force after its sine."
        ),
    ),
    "prediction": (
        "Linear prediction against holding the last value",
        _prediction,
        "The free motion of figure 8.3, uncompensated.",
    ),
    "users": (
        "More users",
        _users,
        "Theory, all-to-all, the worse of normal and tangential couplers, relaxed hands.",
    ),
}
"""Name of the figure -> title, sentences, caption."""


def _range(limit: Limit) -> str:
    return f"{limit.holds:.3g} to {limit.breaks:.3g}"


def _ranges(limits: Sequence[Limit]) -> str:
    return ", ".join(
        dict.fromkeys(f"{one.holds:.2g} and {one.breaks:.2g}" for one in limits if one.breaks > 0)
    )


def _predictions(limits: Sequence[Limit]) -> str:
    found = [one.predicted for one in limits if one.predicted is not None]
    return ", ".join(f"{value:.3g}" for value in found)
