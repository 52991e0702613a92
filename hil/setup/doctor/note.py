"""What ``cohaptic doctor`` says of one thing."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Health(StrEnum):
    """How it stands with one thing."""

    GOOD = "good"
    POOR = "poor"
    """Devices run, worse than they could."""
    BAD = "bad"
    """No force, or none worth the name, until it is put right."""


@dataclass(frozen=True, slots=True)
class DoctorNote:
    """One thing that was looked at; ``sentence`` says how it stands, and what to do."""

    name: str
    health: Health
    sentence: str


def good(name: str, sentence: str) -> DoctorNote:
    """All is as it should be."""
    return DoctorNote(name, Health.GOOD, sentence)


def poor(name: str, sentence: str) -> DoctorNote:
    """It could be better."""
    return DoctorNote(name, Health.POOR, sentence)


def bad(name: str, sentence: str) -> DoctorNote:
    """It has to be put right."""
    return DoctorNote(name, Health.BAD, sentence)
