"""The options of commands that leave drawings in a run's folder."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

Command = Callable[..., Any]


def drawing_options(command: Command) -> Command:
    """``--figure`` and ``--report``, each with its opposite."""
    report = click.option(
        "--report/--no-report", default=None, help="Make report.html.  [default: as the figure]"
    )
    figure = click.option(
        "--figure/--no-figure", default=True, help="Draw overview.png after the run."
    )
    return figure(report(command))
