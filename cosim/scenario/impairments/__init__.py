"""What happens to packets on their way: one file for each impairment, its form to its draw.

A package brings its own through the entry point group ``cohaptic.impairments``; what it has to
say is :class:`Impairment` (how it is written and resolved) and :class:`Effect` (what it does).
"""

from __future__ import annotations

from cosim.scenario.impairments.effect import LOST, NO_COPY, Average, Effect, PacketBlock
from cosim.scenario.impairments.impairment import Impairment, ImpairmentProblem, Setting

__all__ = [
    "LOST",
    "NO_COPY",
    "Average",
    "Effect",
    "Impairment",
    "ImpairmentProblem",
    "PacketBlock",
    "Setting",
]
