"""Which element of a source drives which element of a target."""

from __future__ import annotations

from collections.abc import Iterator

from cosim.base.component import Causality
from cosim.base.errors import InputError
from cosim.master.components.interface import Element, Interface, Selection
from cosim.scenario import Connection


def match_elements(
    connection: Connection,
    source: Interface,
    origin: Selection,
    target: Interface,
    selected: Selection,
) -> Iterator[tuple[Element, Element]]:
    """Pairs of elements: by place for variables and arrays, by name for terminals and groups."""
    if origin.named != selected.named:
        raise InputError(
            f"{connection} joins {_a(origin.kind)} to {_a(selected.kind)}; give both ends as "
            "variables, or both as terminals or groups"
        )
    if origin.named:
        pairs = [
            (element, selected.members[member])
            for member, element in origin.members.items()
            if member in selected.members
            and source.variables[element.variable].causality in _READABLE
            and target.variables[selected.members[member].variable].causality is Causality.INPUT
        ]
        if not pairs:
            outputs = [
                member
                for member, element in origin.members.items()
                if source.variables[element.variable].causality in _READABLE
            ]
            inputs = [
                member
                for member, element in selected.members.items()
                if target.variables[element.variable].causality is Causality.INPUT
            ]
            raise InputError(
                f"{connection}: no output of {connection.source} ({_list(outputs)}) has the name "
                f"of an input of {connection.target} ({_list(inputs)})"
            )
        yield from pairs
        return
    if len(origin.members) != len(selected.members):
        raise InputError(
            f"{connection}: {connection.source} has {_count(origin)} and {connection.target} "
            f"{_count(selected)}"
        )
    for there, here in zip(origin.members.values(), selected.members.values(), strict=True):
        if source.variables[there.variable].causality not in _READABLE:
            causality = source.variables[there.variable].causality
            raise InputError(
                f"{connection}: {connection.source} is {_a(causality)}, not an output"
                + (", turn the arrow round" if causality is Causality.INPUT else "")
            )
        check_input(connection, target, here)
        yield there, here


_READABLE = {Causality.OUTPUT}


def check_input(connection: Connection, target: Interface, element: Element) -> None:
    """Whether an element can be driven.

    Raises:
        InputError: it is neither an input nor something that is turned.
    """
    causality = target.variables[element.variable].causality
    if causality is not Causality.INPUT and element.variable not in target.knobs:
        raise InputError(f"{connection}: {connection.target} is {_a(causality)}, not an input")


def _a(word: str) -> str:
    return f"{'an' if word[0] in 'aeiou' else 'a'} {word}"


def _count(selection: Selection) -> str:
    number = len(selection.members)
    return "one element" if number == 1 else f"{number} elements"


def _list(names: list[str]) -> str:
    return ", ".join(names[:6]) + (" …" if len(names) > 6 else "") if names else "none"
