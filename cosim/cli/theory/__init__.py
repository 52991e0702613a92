"""``cohaptic theory``: one short file a subcommand, each imported only when it is called."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any, ClassVar

import click

SUBCOMMANDS = {
    "admittance": "What a user feels over frequency, by both definitions.",
    "boundary": "All stable intervals along one parameter.",
    "damping": "DC damping that a user feels, and the compensation that nulls it.",
    "design": "Gains that follow from a measured network, as a scenario overlay.",
    "figure": "Draw figure 5.1 to 5.4, 6.2, 6.4 or 6.5.",
    "loss": "Critical packet loss, and mean-square stability at a given one.",
    "map": "Stability over a plane of two parameters.",
    "margins": "Distance to instability in gain, delay and loss.",
    "modes": "How a run moves: growth, frequency, and who takes part.",
    "page": "The page that compares chapters 3 to 6 with this library.",
    "passivity": "Passivity and Z-width on a device with physical damping.",
    "radius": "Spectral radius of a loop: stable below 1.",
    "robust": "What holds whatever the network and the hands do.",
    "stiffness": "Stiffness that a user feels in rigid contact.",
    "table": "Print table 6.1 or 6.2, the thesis's numbers beside ours.",
}


class TheoryGroup(click.Group):
    """Subcommands that are imported when used: ``command`` in a module of each one's name."""

    package: ClassVar[str] = "cosim.cli.theory"
    summaries: ClassVar[Mapping[str, str]] = SUBCOMMANDS

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The subcommand names in alphabetical order."""
        return sorted(self.summaries)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return one subcommand, or ``None`` where there is none of that name."""
        if cmd_name not in self.summaries:
            return None
        command: Any = importlib.import_module(
            f"{self.package}.{cmd_name.replace('-', '_')}"
        ).command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list without importing a single subcommand."""
        with formatter.section("Commands"):
            formatter.write_dl(sorted(self.summaries.items()))


@click.group(cls=TheoryGroup, context_settings={"help_option_names": ["-h", "--help"]})
def command() -> None:
    """Stability, transparency, damping and design of cooperative haptics over a network.

    Names follow the thesis: k_1, b_2 (centralized); k_11, k_12, k_o (distributed); k, b (single).
    Naming one of a pair (k_12 for k_12 and k_21) sets both unless both are named; b sets the
    damping of every coupler. Units are N/m, N·s/m, kg and s.
    """
