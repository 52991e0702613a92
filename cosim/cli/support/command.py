"""What every subcommand is: a command whose ``--json`` also answers bad input with an object."""

from __future__ import annotations

import json
from typing import Any

import click

from cosim.base.errors import CohapticError, InputError, InputErrors


class JsonCommand(click.Command):
    """A command whose ``--json`` holds for bad input as well; the sentences stay on stderr."""

    def make_context(
        self,
        info_name: str | None,
        args: list[str],
        parent: click.Context | None = None,
        **extra: Any,
    ) -> click.Context:
        """Read the arguments; click has taken them from ``args`` when it refuses one."""
        wanted = "--json" in args and any(each.name == "as_json" for each in self.params)
        try:
            return super().make_context(info_name, args, parent, **extra)
        except click.UsageError as error:
            if wanted:
                _answer([_problem(error.format_message())])
            raise
        except CohapticError as error:
            if wanted:
                _answer(problems_of(error))
            raise

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except CohapticError as error:
            if ctx.params.get("as_json"):
                _answer(problems_of(error))
            raise
        except click.UsageError as error:
            if ctx.params.get("as_json"):
                _answer([_problem(error.format_message())])
            raise


def problems_of(error: CohapticError) -> list[dict[str, Any]]:
    """The sentences of an error with their places; ``None`` where there is none."""
    several = error.errors if isinstance(error, InputErrors) else [error]
    return [_entry(each) for each in several]


def _entry(error: CohapticError) -> dict[str, Any]:
    if not isinstance(error, InputError):
        return _problem(str(error))
    place = error.location
    return _problem(error.message) | (
        {} if place is None else {"file": place.file, "line": place.line, "column": place.column}
    )


def _problem(message: str) -> dict[str, Any]:
    return {"message": message, "file": None, "line": None, "column": None}


def _answer(problems: list[dict[str, Any]]) -> None:
    click.echo(json.dumps({"ok": False, "problems": problems}, indent=2))
