"""A connection in one line: ``a.b -> c.d via lan at 128 Hz delay 1 tick initial start``."""

from __future__ import annotations

import re

from cosim.base.document.node import Node

CLAUSES = {"via": "via", "at": "rate", "delay": "delay", "initial": "initial"}
"""Word in the one-line form -> key in the mapping form."""

FORM = "'source.output -> target.input', with 'via CHANNEL', 'at RATE', 'delay TIME' behind it"

_ENDS = re.compile(r"\s*(?P<source>\S+)\s*->\s*(?P<target>\S+)(?P<rest>\s.*)?", re.DOTALL)
_CLAUSE = re.compile(rf"\s+({'|'.join(CLAUSES)})\s+(.*?)(?=\s+(?:{'|'.join(CLAUSES)})\s|\s*$)")
_NUMBER = re.compile(r"\d{1,9}")


class NotationError(ValueError):
    """The text is not a connection; says how one is written."""


def parse_connection(text: str) -> dict[str, str | int]:
    """The mapping form of a one-line connection.

    Raises:
        NotationError: the text does not follow the form, or a clause is there twice.
    """
    ends = _ENDS.fullmatch(text)
    if not ends:
        raise NotationError(f"'{text}' is not a connection; write {FORM}.")
    found: dict[str, str | int] = {"from": ends["source"], "to": ends["target"]}
    rest, position = ends["rest"] or "", 0
    while rest[position:].strip():
        clause = _CLAUSE.match(rest, position)
        if not clause:
            raise NotationError(f"'{rest[position:].strip()}' is not understood; write {FORM}.")
        word, value = clause.groups()
        if CLAUSES[word] in found:
            raise NotationError(f"'{word}' is there twice in '{text}'.")
        found[CLAUSES[word]] = int(value) if _NUMBER.fullmatch(value) else value
        position = clause.end()
    return found


def as_mapping(node: Node) -> Node:
    """A one-line connection as the mapping that it stands for; what is neither stays as it is."""
    if not isinstance(node.value, str):
        return node
    try:
        parts = parse_connection(node.value)
    except NotationError:
        return node  # validation reports it with everything else
    return Node({key: Node(part, node.place) for key, part in parts.items()}, node.place)


def components_in(target: str) -> list[str]:
    """Names of the components in a target; none for a measure of the whole scenario.

    ``a.x``, the difference ``a.x - b.x`` and the length ``|a.p - b.p|`` speak of components;
    ``contact_losses`` of the scenario.
    """
    sides = target.strip().strip("|").split(" - ")
    return [side.strip().partition(".")[0] for side in sides if "." in side]
