"""Where runs begin in the middle and what comes before cannot be run, every point says so alike."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cosim.reading import FORMS
from cosim.sweep.planning.plan import Request, plan_of
from cosim.sweep.sweep import run_sweep

PARTS = {
    "source": {"fmu": "signal", "rate": 128, "station": "a", "parameters": {"mode": "sine"}},
    "hand": {"fmu": "hand", "rate": 128, "station": "b"},
}
SCENARIO = {
    "cohaptic": 1,
    "duration": 0.5,
    "components": PARTS,
    "channels": {"lan": {"between": ["a", "b"], "rate": 128, "round_trip_delay": 4}},
    "connections": [{"from": "source.value", "to": "hand.force", "via": "lan"}],
}
TURNED = {"events": [{"at": 0.0625, "set": {"source.amplitude": 2}}]}
FAILING = """
from tests.support.master.resumable_parts import Saved


class Part(Saved):
    def step(self, tick):
        if tick == 3:
            raise RuntimeError("it is enough")
        super().step(tick)
"""


@pytest.mark.parametrize(
    ("more", "status", "said"),
    [
        (TURNED, "refused", "source.amplitude is turned while it runs, so that runs cannot begin"),
        (
            {"components": {**PARTS, "part": {"python": "part.py:Part", "rate": 128}}},
            "error",
            "it is enough",
        ),
    ],
)
def test_every_point_says_the_same(
    tmp_path: Path, more: dict[str, object], status: str, said: str
) -> None:
    file = tmp_path / "test.yaml"
    (tmp_path / "part.py").write_text(FAILING)
    file.write_text(json.dumps({**SCENARIO, **more}))
    request = Request(
        scenario=file,
        vary={"lan.loss": [0.1, 0.2, 0.3]},
        measure={"hand.position": "max"},
        start="0.25",
        check_every=0,
    )
    found = run_sweep(plan_of(request, FORMS), tmp_path / "out", workers=0)
    assert [each.status for each in found.results] == [status] * 3
    assert all(said in each.message for each in found.results), found.results
    assert len({each.message for each in found.results}) == 1
