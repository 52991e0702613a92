"""The ``cohaptic`` command: one short file a command, each imported only when it is called."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import click

from cosim.base.errors import CohapticError
from cosim.base.system.garbage import collect_seldom
from cosim.cli.support.stdout import reserve_stdout

# Command name -> one-line help. The command itself is ``cosim.cli.<name>:command``, or in HOMES.
COMMANDS = {
    "check": "Read a scenario, load its FMUs, and report every problem in one go.",
    "compare": "Tell in what two runs differ: scenario, measures, first tick and signal.",
    "completion": "Print what makes a shell complete commands, scenarios, runs and signals.",
    "device": "Real devices: find, check, home, calibrate, emulate.",
    "doctor": "Look whether this machine can run devices, and say what to do.",
    "fmu": "List, inspect, validate, export, write and build FMUs.",
    "identify": "Tell inertia, friction, latency, offset and gain of a device from its runs.",
    "intent": "Fit the predictor of a hand's intent to recorded hands.",
    "keygen": "Make a pre-shared key for a link between workstations.",
    "live": "Watch a paced run from another terminal.",
    "merge": "Align the records of the stations of one session.",
    "new": "Write a starter scenario, by questions.",
    "netchar": "Measure the network between two machines: delay, jitter, loss, rate.",
    "plot": "Draw signals of runs: over time, difference, spectrum, phase plane, histogram.",
    "play": "Take a user's place by hand, in a browser.",
    "record": "Look into a run folder: digest, summary, export.",
    "render": "Draw the scene of a run as a gif, webp or mp4.",
    "replay": "Compute a run again, and tell whether it is the same, bit for bit.",
    "run": "Run a scenario and record it.",
    "runs": "List runs, and find those that have a value.",
    "scenarios": "List the bundled scenarios, with a sentence and a picture each.",
    "ssp": "Read systems of SSP and OSP, and write scenarios as SSP.",
    "station": "Run one workstation of a scenario, linked to the others over UDP.",
    "study": "Studies with people: trials in order, questions, a tidy table.",
    "sweep": "Run a scenario many times: grids, samples, seeds, boundaries.",
    "thesis": "Rerun the experiments of chapters 7 and 8 and judge the thesis by them.",
    "theory": "Stability, transparency, damping and design (chapters 3 to 6).",
}

HOMES = {
    "compare": "recorded.compare",
    "completion": "first_steps.completion",
    "identify": "recorded.identify",
    "intent": "recorded.intent",
    "new": "first_steps.new",
    "replay": "recorded.replay",
    "runs": "recorded.listing",
    "scenarios": "first_steps.scenarios",
}
"""Modules of commands that are called otherwise than the command."""


class LazyGroup(click.Group):
    """A click group whose commands are imported only when they are used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The command names in alphabetical order."""
        return sorted(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return one command, or ``None`` where there is none of that name."""
        if cmd_name not in COMMANDS:
            return None
        command: Any = importlib.import_module(f"cosim.cli.{HOMES.get(cmd_name, cmd_name)}").command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the command list without importing a single command."""
        with formatter.section("Commands"):
            formatter.write_dl(sorted(COMMANDS.items()))


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="cohaptic")
def cli() -> None:
    """Co-simulation and hardware in the loop for cooperative haptics over a network."""


def main() -> None:
    """Run the command line; a user's mistake ends in a sentence and an exit status."""
    reserve_stdout()
    collect_seldom()
    try:
        cli(standalone_mode=False)
    except click.exceptions.Exit as stop:
        sys.exit(stop.exit_code)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except click.Abort:
        sys.exit(1)
    except CohapticError as error:
        click.echo(str(error), err=True)
        sys.exit(error.exit_status)
