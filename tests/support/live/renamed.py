"""A component that draws a box under names of its own."""

from __future__ import annotations

from pathlib import Path

BOX = ("ort_waagrecht", "ort_senkrecht", "verdrehung")

_MODULE = """
from cosim.base.component import Causality, Component, Variable
from cosim.base.meaning import Meaning

POSE = (Meaning.BOX_X, Meaning.BOX_Y, Meaning.BOX_ANGLE)


class Crate(Component):
    @property
    def variables(self):
        outputs = [
            Variable(name=name, causality=Causality.OUTPUT, meaning=meaning)
            for name, meaning in zip(NAMES, POSE)
        ]
        side = Variable(
            name="kante",
            causality=Causality.PARAMETER,
            variability="fixed",
            start=0.3,
            meaning=Meaning.BOX_SIDE,
        )
        return [*outputs, side]

    def initialise(self, setup, inputs, outputs):
        pass


NAMES = %r
"""

_SCENARIO = """
cohaptic: 1
title: A crate of somebody else
duration: 1 s
rates: {control: 1024 Hz}
components:
  mine: {python: "crate:Crate"}
"""


def write_scenario(folder: Path) -> Path:
    """The scenario's file, with its module beside it."""
    (folder / "crate.py").write_text(_MODULE % (BOX,), encoding="utf-8")
    file = folder / "crate.yaml"
    file.write_text(_SCENARIO, encoding="utf-8")
    return file
