"""A person's pointer as a component: raw samples of where the fingers should be, and their age.

Nothing is filtered here. What it shows is recorded, so that a session can be played back under
other settings, and under the same ones bit for bit; an ``operator`` whose trajectory is ``tracked``
makes a smooth hand of it. Without a page (a scenario that is run again) nobody is ever there.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from math import hypot

from cosim.base.component import Causality, Cells, Component, Setup, Variable, VariableType
from cosim.base.meaning import Meaning, Slot
from cosim.live.mailbox import FINGERS, Mailbox

SILENCE_SECONDS = 0.25
"""A page says where its pointer is in every frame; one that does not for so long is not there."""


def _position(finger: int) -> Variable:
    return Variable(
        name=f"position_{finger}",
        causality=Causality.OUTPUT,
        unit="m",
        shape=(2,),
        start=0.0,
        description=f"Where finger {finger} should be, world frame",
        meaning=(Meaning.POINTER_X, Meaning.POINTER_Y),
        belongs_to=(Slot(finger=finger), Slot(finger=finger)),
    )


def _centre(finger: int) -> Variable:
    return Variable(
        name=f"centre_{finger}",
        causality=Causality.PARAMETER,
        variability="fixed",
        unit="m",
        shape=(2,),
        start=0.0,
        description=f"Middle of what finger {finger} can reach, world frame",
        meaning=(Meaning.REACH_X, Meaning.REACH_Y),
        belongs_to=(Slot(finger=finger), Slot(finger=finger)),
    )


VARIABLES = (
    *(_position(finger) for finger in range(1, FINGERS + 1)),
    Variable(
        name="valid",
        type=VariableType.BOOLEAN,
        causality=Causality.OUTPUT,
        variability="discrete",
        start=False,
        description="Whether somebody is there",
        meaning=Meaning.POINTER_VALID,
    ),
    Variable(
        name="count",
        type=VariableType.INT64,
        causality=Causality.OUTPUT,
        variability="discrete",
        start=0,
        description="Number of the sample",
        meaning=Meaning.POINTER_COUNT,
    ),
    Variable(
        name="age",
        causality=Causality.OUTPUT,
        unit="s",
        start=0.0,
        description="Time since the sample was taken",
        meaning=Meaning.POINTER_AGE,
    ),
    *(_centre(finger) for finger in range(1, FINGERS + 1)),
    Variable(
        name="reach",
        causality=Causality.PARAMETER,
        variability="fixed",
        unit="m",
        start=0.07,
        minimum=0.0,
        description="How far from that middle a finger may be led",
        meaning=Meaning.REACH,
    ),
)


class Pointer(Component):
    """Shows the newest sample of a mailbox; nobody is there without one."""

    feedthrough = False

    def __init__(self, mailbox: Mailbox | None = None) -> None:
        self._mailbox = mailbox
        self._count = 0
        self._time = 0.0
        self._present = False

    @property
    def variables(self) -> Sequence[Variable]:
        """The raw samples, and how far the fingers may be led."""
        return VARIABLES

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Nobody is there yet, whoever was there before this run."""
        given = setup.parameters
        self._reach = float(given.get("reach", 0.07))
        zero = (0.0, 0.0)
        self._centres = [tuple(given.get(f"centre_{n}", zero)) for n in range(1, FINGERS + 1)]
        self._positions = [outputs[f"position_{n}"] for n in range(1, FINGERS + 1)]
        self._valid, self._age = outputs["valid"], outputs["age"]
        self._counted = outputs["count"]
        for position, centre in zip(self._positions, self._centres, strict=True):
            position[:] = centre
        self._present = False
        self._count = 0 if self._mailbox is None else self._mailbox.count

    def read(self, tick: int) -> None:
        """Take what the page last said."""
        box = self._mailbox
        if box is None:
            return
        count = box.count
        if count != self._count:
            sample = box.newest()
            if sample is not None:
                self._take(count, sample)
        age = time.monotonic() - self._time
        here = self._present and age <= SILENCE_SECONDS
        self._valid[0] = here
        self._age[0] = age if here else 0.0

    def _take(self, count: int, sample: list[float]) -> None:
        self._count, self._time, self._present = count, sample[0], sample[1] > 0.0
        self._counted[0] = count
        for number, (position, centre) in enumerate(
            zip(self._positions, self._centres, strict=True)
        ):
            x, y = sample[2 + 2 * number] - centre[0], sample[3 + 2 * number] - centre[1]
            share = min(1.0, self._reach / max(hypot(x, y), 1e-9))
            position[0], position[1] = centre[0] + share * x, centre[1] + share * y
