"""The scenario language: YAML in, a typed and checked :class:`Scenario` out.

``load`` reads a file with its includes, overlays and overrides; every error says where.
"""

from __future__ import annotations

from cosim.scenario.load import load
from cosim.scenario.model import (
    Bernoulli,
    Channel,
    Component,
    Connection,
    Delay,
    Direction,
    Duplication,
    GilbertElliott,
    Jitter,
    Kind,
    Record,
    Reference,
    Reorder,
    Scenario,
)

__all__ = [
    "Bernoulli",
    "Channel",
    "Component",
    "Connection",
    "Delay",
    "Direction",
    "Duplication",
    "GilbertElliott",
    "Jitter",
    "Kind",
    "Record",
    "Reference",
    "Reorder",
    "Scenario",
    "load",
]
