"""A loaded scenario written out again as one self-contained YAML file."""

from __future__ import annotations

from cosim.scenario.model import Scenario


def to_yaml(scenario: Scenario) -> str:
    """The whole scenario as YAML, every default and override in it."""
    raise NotImplementedError
