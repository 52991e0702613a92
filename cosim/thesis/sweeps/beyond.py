"""What lies past the thesis and takes many short runs: sweeps in memory, beside the theory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self, cast

from cosim.thesis.experiments import Task, bundled_file, in_parallel
from cosim.thesis.sweeps.breaking import CURVES, DELAYS, Curve, Limit, find_limit
from cosim.thesis.sweeps.free_motions import DELAYS as PREDICTED_DELAYS
from cosim.thesis.sweeps.free_motions import PREDICTORS, REALISM, prediction
from cosim.thesis.sweeps.trials import Motion, free_motion

USERS = (2, 3, 4)
RADIUS_DELAYS = (0, 1, 2, 3, 4)
_CARRIED_BY = {
    2: "thesis/free_motion",
    3: "thesis/three_users",
    4: "thesis/four_users",
}


@dataclass(frozen=True, slots=True)
class Beyond:
    """The results of all sweeps.

    Attributes:
        limits: where the grasp breaks, curve by curve, in the order of the delays.
        realism: the free motion by what is ideal in it.
        predictors: the free motion by predictor and round trip (network samples).
        radii: the theory's spectral radius by number of users, at each of ``RADIUS_DELAYS``.
    """

    limits: Mapping[Curve, tuple[Limit, ...]]
    realism: Mapping[str, Motion]
    predictors: Mapping[tuple[str, int], Motion]
    radii: Mapping[int, tuple[float, ...]]

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> Self:
        """What ``as_json`` gave."""
        return cls(
            limits={
                curve: tuple(Limit(**one) for one in row) for curve, row in plain["limits"].items()
            },
            realism={name: Motion(**motion) for name, motion in plain["realism"].items()},
            predictors={
                (one["predictor"], one["round_trip_delay"]): Motion(
                    one["net_force"], one["ripple"], one["drift"]
                )
                for one in plain["predictors"]
            },
            radii={int(users): tuple(row.values()) for users, row in plain["radii"].items()},
        )

    def as_json(self) -> dict[str, Any]:
        """The same with plain keys."""
        return {
            "limits": {curve: [asdict(one) for one in row] for curve, row in self.limits.items()},
            "realism": {name: asdict(motion) for name, motion in self.realism.items()},
            "predictors": [
                {"predictor": name, "round_trip_delay": delay, **asdict(motion)}
                for (name, delay), motion in self.predictors.items()
            ],
            "radii": {
                str(users): {str(n): one for n, one in zip(RADIUS_DELAYS, row, strict=True)}
                for users, row in self.radii.items()
            },
        }


def sweep(workers: int | None = None) -> Beyond:
    """Run every sweep, as many at a time as there are workers.

    Raises:
        CohapticError: a scenario cannot be used, or a run failed.
    """
    limits: list[Task] = [
        (find_limit, (curve, delay)) for curve in CURVES for delay in DELAYS[curve]
    ]
    predicted = [(name, delay) for delay in PREDICTED_DELAYS for name in PREDICTORS]
    motions: list[Task] = [(free_motion, (sets,)) for sets in REALISM.values()]
    motions += [(free_motion, (prediction(name, delay),)) for name, delay in predicted]
    radii: list[Task] = [(radii_of, (users,)) for users in USERS]
    results = in_parallel([*limits, *motions, *radii], workers)
    found = cast("list[Limit]", results[: len(limits)])
    moved = cast("list[Motion]", results[len(limits) : len(limits) + len(motions)])
    return Beyond(
        limits={curve: tuple(one for one in found if one.curve == curve) for curve in CURVES},
        realism=dict(zip(REALISM, moved, strict=False)),
        predictors=dict(zip(predicted, moved[len(REALISM) :], strict=True)),
        radii=dict(zip(USERS, results[len(limits) + len(motions) :], strict=True)),
    )


def radii_of(users: int) -> tuple[float, ...]:
    """Spectral radius of the worse of carry and lift with one finger a user, over the delays."""
    from cosim.analysis.modes import distributed_modes
    from cosim.scenario import load
    from cosim.theory.models.timing import PathDelay, Timing
    from cosim.theory.stability.spectral_radius import stability

    models = distributed_modes(load(bundled_file(_CARRIED_BY[users])), fingers=1).values()
    return tuple(
        max(
            stability(model, Timing(delay=PathDelay.round_trip(delay))).spectral_radius
            for model in models
        )
        for delay in RADIUS_DELAYS
    )
