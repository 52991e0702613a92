"""Collecting input errors, each with its place in the scenario, to report them all at once."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager

from cosim.base.errors import InputError, InputErrors
from cosim.scenario import Scenario


class Problems:
    """The errors found so far."""

    def __init__(self, scenario: Scenario) -> None:
        self.errors: list[InputError] = []
        self._scenario = scenario
        self._ignored: tuple[type[InputError], ...] = ()

    def ignore(self, kind: type[InputError]) -> None:
        """Errors of this kind only follow from one that was reported."""
        self._ignored = (*self._ignored, kind)

    @contextmanager
    def at(self, path: tuple[str | int, ...]) -> Generator[None]:
        """Note an error raised inside, with the place of ``path`` unless it brings its own."""
        try:
            yield
        except InputErrors as several:
            self.errors.extend(several.errors)
        except self._ignored:
            pass
        except InputError as error:
            place = error.location or self._scenario.locate(path)
            self.errors.append(InputError(error.message, place))

    def raise_any(self) -> None:
        """Raise what was found: one error as itself, several together."""
        if len(self.errors) == 1:
            raise self.errors[0]
        if self.errors:
            raise InputErrors(self.errors)
