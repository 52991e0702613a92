"""The scenario language: YAML in, a typed and checked :class:`Scenario` out.

``load`` reads a file with its includes, overlays and overrides; every error says where.
"""

from __future__ import annotations

from cosim.scenario.load import load
from cosim.scenario.model import (
    Channel,
    Connection,
    Delay,
    Direction,
    Event,
    Kind,
    KnobRange,
    Record,
    Reference,
    Scenario,
    ScenarioComponent,
)

__all__ = [
    "Channel",
    "Connection",
    "Delay",
    "Direction",
    "Event",
    "Kind",
    "KnobRange",
    "Record",
    "Reference",
    "Scenario",
    "ScenarioComponent",
    "load",
]
