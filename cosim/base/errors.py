"""The exceptions a user can meet; each carries the process exit status it stands for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Location:
    """A place in a text file; lines and columns count from 1.

    Line 0 stands for a place that has no lines, such as an option on the command line.
    """

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}" if self.line else self.file


class CohapticError(Exception):
    """Base of every error that is shown to a user as a sentence instead of a traceback."""

    exit_status = 1


class InputError(CohapticError, ValueError):
    """What the user wrote cannot be used: a scenario, an option, an FMU file. Exit status 2."""

    exit_status = 2

    def __init__(self, message: str, location: Location | None = None) -> None:
        self.message = message
        self.location = location
        super().__init__(f"{location}: {message}" if location is not None else message)

    def __reduce__(self) -> tuple[Any, ...]:
        """With its place, between processes too."""
        return type(self), (self.message, self.location)


class InputErrors(InputError):
    """Several input errors found in one go, reported together in file order."""

    def __init__(self, errors: list[InputError]) -> None:
        self.errors = sorted(errors, key=_file_order)
        ValueError.__init__(self, "\n".join(str(error) for error in self.errors))
        self.message = str(self)
        self.location = None

    def __reduce__(self) -> tuple[type[InputErrors], tuple[list[InputError]]]:
        return type(self), (self.errors,)


class RunError(CohapticError, RuntimeError):
    """A run started and could not go on: an FMU failed, a device faulted. Exit status 1."""


class EndAsked(RunError):
    """A model has come to its end and asked for that of the run, which is then well over."""


def _file_order(error: InputError) -> tuple[str, int, int]:
    place = error.location
    return (place.file, place.line, place.column) if place is not None else ("", 0, 0)
