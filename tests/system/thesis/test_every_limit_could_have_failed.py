"""Each single limit that decides a statement fails in some run: an ablation's, or one made here.

A statement's ablations must fail it as a whole; a limit that holds whatever is done would still
stand beside those that do not, and say nothing.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.scenario import load
from cosim.thesis.claims.chapter_8 import STATEMENTS
from cosim.thesis.claims.past import EXTENSIONS
from cosim.thesis.experiments import run_one
from cosim.thesis.results import Results
from tests.support.experiments import NUMBERS

Limit = tuple[str, str]

BY_DESIGN = {("grasp_deadband", "deadband"): {("vr_a.packets_due", "final_equals")}}
"""What counts and decides nothing: 128 packets a second are due whatever they say."""
SMOOTH = ("static_friction=0", "kinetic_friction=0")
LOST = ("channels.lan.loss=0.97",)
STIFF = ("coupling_stiffness=20000",)


def of_models(scenario: str, models: set[str], *texts: str) -> tuple[str, ...]:
    parts = load(f"thesis/{scenario}").components.values()
    names = [part.name for part in parts if part.source in models]
    return tuple(f"components.{name}.parameters.{text}" for name in names for text in texts)


def worlds(scenario: str, *texts: str) -> tuple[str, ...]:
    return of_models(scenario, {"distributed_workstation", "central_server"}, *texts)


OTHERS: dict[tuple[str, str], list[tuple[str, ...]]] = {
    **{
        (name, label): [worlds(name, *SMOOTH)]
        for name, label in (
            ("grasp_centralized_firm_hand", "damped_hand"),
            ("grasp_centralized_soft", "softer"),
            ("grasp_centralized_wave", "wave"),
            ("grasp_distributed_apart", "together"),
            ("turning_printed", "turning"),
        )
    },
    ("turning", "turning"): [worlds("turning", *SMOOTH, "compensation.theta=-0.025")],
    ("grasp_distributed_lossy", "grasp"): [LOST],
    ("grasp_distributed_lan_2006", "grasp"): [LOST],
    **{
        (name, name): [
            worlds(name, *STIFF),
            of_models(name, {"operator"}, "trajectory=hold"),
        ]
        for name in ("three_users", "four_users")
    },
}


def limits_and_failures() -> dict[tuple[str, str], tuple[set[Limit], set[Limit]]]:
    """Of every label: its limits, and those that one of its ablations failed."""
    runs = Results.read(NUMBERS).runs
    found: dict[tuple[str, str], tuple[set[Limit], set[Limit]]] = {}

    def entries(run: str, label: str):
        return [one for one in runs[run]["expectations"] if one["label"] == label]

    for statement in (*STATEMENTS, *EXTENSIONS):
        for each in statement.evidence:
            limits, _ = found.setdefault((each.scenario, each.label), (set(), set()))
            limits |= {(e["target"], e["predicate"]) for e in entries(each.run, each.label)}
        for each in statement.ablations:
            place = each.evidence.scenario, each.evidence.label
            _, failed = found.setdefault(place, (set(), set()))
            failed |= {
                (e["target"], e["predicate"])
                for e in entries(each.name, place[1])
                if e["passed"] is False
            }
    return found


FOUND = limits_and_failures()


def test_every_limit_that_no_ablation_fails_has_a_run_here() -> None:
    open_ = {
        place
        for place, (limits, failed) in FOUND.items()
        if limits - failed - BY_DESIGN.get(place, set())
    }
    assert open_ == set(OTHERS)


@pytest.mark.slow
@pytest.mark.parametrize("place", OTHERS, ids="-".join)
def test_each_limit_fails_somewhere(place: tuple[str, str], tmp_path: Path) -> None:
    scenario, label = place
    limits, failed = FOUND[place]
    failed = set(failed)
    for number, sets in enumerate(OTHERS[place]):
        ran = run_one("other", f"thesis/{scenario}", sets, tmp_path / str(number))
        failed |= {
            (e["target"], e["predicate"])
            for e in ran.summary["expectations"]
            if e["label"] == label and not e["passed"]
        }
    assert failed == limits
