"""``cohaptic theory robust``: one short file a subcommand, each imported only when it is called."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import click

from cosim.cli.theory import TheoryGroup


class RobustGroup(TheoryGroup):
    """The subcommands of ``theory robust``."""

    package: ClassVar[str] = "cosim.cli.theory.robust"
    summaries: ClassVar[Mapping[str, str]] = {
        "bursts": "Stability with any losses of at most so many packets in a row.",
        "hands": "Stability with every hand's mass and impedance in intervals (μ).",
        "ports": "Llewellyn's absolute stability; Lawrence's and Yokokohji's indices.",
        "switching": "Stability with delays that switch arbitrarily in a set.",
        "z-width": "The stiffest wall by rule, by eigenvalues, and simulated as built.",
    }


@click.group(cls=RobustGroup)
def command() -> None:
    """What holds whatever the network and the hands do: certificates and worst cases."""
