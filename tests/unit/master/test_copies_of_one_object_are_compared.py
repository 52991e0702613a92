"""Peers that simulate copies of one object are told where its parameters differ."""

from __future__ import annotations

import pytest

from cosim.analysis import load_tuned
from cosim.master.run.simulation import assemble


@pytest.mark.parametrize(
    ("sets", "named"),
    [
        ((), []),
        (("components.vr_a.parameters.mass=0.5",), ["mass is 0.5 in vr_a and 0.4 in vr_b"]),
        (("components.vr_b.parameters.side=0.08",), ["side is 0.1 in vr_a and 0.08 in vr_b"]),
        # Where a finger stands is a workstation's own affair.
        (("components.vr_a.parameters.finger_1.base_x=-0.07",), []),
    ],
)
def test_a_difference_is_noted_with_both_values(sets, named) -> None:
    with assemble(load_tuned("two_users_box", (), sets)) as simulation:
        notes = [note for note in simulation.notes if "copies of one object" in note]
    assert len(notes) == len(named)
    for note, words in zip(notes, named, strict=True):
        assert words in note
