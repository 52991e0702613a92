"""Options that could act on nothing in this call are refused, with what to write instead."""

from __future__ import annotations

from collections.abc import Mapping

from cosim.base.errors import InputError


def refuse_without(needed: str, given: Mapping[str, object], because: str) -> None:
    """Refuse every option of ``given`` that has a value: ``needed`` is not there.

    Args:
        needed: the option or argument without which they do nothing.
        given: their values by name; ``None``, ``False`` and nothing are no value.
        because: what they would have acted on, as half a sentence.

    Raises:
        InputError: one or more have a value.
    """
    named = given_of(given)
    if named:
        raise InputError(
            f"{' and '.join(named)} without {needed}: {because}; add {needed}, or leave "
            f"{'it' if len(named) == 1 else 'them'} out."
        )


def given_of(options: Mapping[str, object]) -> list[str]:
    """The names of those that have a value; the number 0 is one."""
    return [
        name
        for name, value in options.items()
        if value is not None and value is not False and value != ()
    ]
