"""The scenario of an excitation, written out: the device and the component that moves it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import ceil

import numpy as np

from cosim.identification.excitation.design import design
from cosim.identification.excitation.envelope import Envelope
from cosim.identification.excitation.trajectory import Trajectory
from cosim.identification.five_bar import Array

FINGER, EXCITATION = "finger", "excitation"


@dataclass(frozen=True, slots=True, kw_only=True)
class ExcitationPlan:
    """What is to be run: ``url`` and ``file`` of the device, and how it is to be moved."""

    url: str
    file: str
    envelope: Envelope
    values: Array
    trajectory: Trajectory
    payload: float

    @property
    def duration(self) -> int:
        """Seconds of the run."""
        return ceil(self.trajectory.duration)

    def use(self, home: tuple[float, float]) -> dict[str, float]:
        """The largest share of each limit that the motion takes, of what may be used of it."""
        tick = 1 / 1024
        return self.envelope.use(self.trajectory.sampled(np.asarray(home), tick), self.values, tick)

    def text(self) -> str:
        """The scenario, as YAML."""
        bar, path = self.envelope.bar, self.trajectory
        values = ", ".join(f"{each:.9g}" for each in self.values)
        loaded = f" with {self.payload * 1e3:g} g on the tip" if self.payload else ""
        return f"""\
cohaptic: 1
title: Excitation that tells inertia and friction of a device{loaded}
description: >
  Written by 'cohaptic identify --plan'. The handle is moved by its own motors alone: nobody holds
  it. Sines of 0.25 to 15 Hz about one pose, inside every limit of {self.file}.
duration: {self.duration} s
rates: {{control: 1024 Hz}}

components:
  {FINGER}:
    device: {{url: {_quoted(self.url)}, file: {_quoted(self.file)}}}
  {EXCITATION}:
    python: "cosim.identification.excitation.controller:Excitation"
    rate: control
    parameters:
      proximal: {bar.proximal:.9g}
      distal: {bar.distal:.9g}
      base: {bar.base:.9g}
      middle: [{path.middle[0]:.9g}, {path.middle[1]:.9g}]   # rad
      slow: {path.slow:.9g}     # rad
      fast: {path.fast:.9g}     # rad/s2
      seconds: {path.seconds:.9g}
      seed: {path.seed}
      payload: {self.payload:.9g}   # kg
      values: [{values}]

connections:
  - {FINGER}.joint_angle -> {EXCITATION}.joint_angle
  - {EXCITATION}.motor_torque -> {FINGER}.motor_torque
"""


def _quoted(text: str) -> str:
    """As YAML reads it back, whatever is in it."""
    return json.dumps(text, ensure_ascii=False)


def plan(
    *,
    url: str,
    file: str,
    envelope: Envelope,
    values: Array,
    home: tuple[float, float],
    seconds: float,
    payload: float,
    seed: int,
) -> ExcitationPlan:
    """The plan for one device.

    Raises:
        InputError: its limits leave no excitation.
    """
    trajectory = design(envelope, values, home, seconds, seed)
    return ExcitationPlan(
        url=url,
        file=file,
        envelope=envelope,
        values=values,
        trajectory=trajectory,
        payload=payload,
    )
