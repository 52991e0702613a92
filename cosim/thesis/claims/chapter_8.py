"""All statements of chapters 7 and 8, and the scenarios that they need."""

from __future__ import annotations

from cosim.thesis.claims.contact import CONTACT
from cosim.thesis.claims.grasp import GRASP
from cosim.thesis.claims.motion import MOTION
from cosim.thesis.claims.statement import Statement

STATEMENTS: tuple[Statement, ...] = (*GRASP, *CONTACT, *MOTION)
