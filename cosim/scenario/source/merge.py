"""How one document goes over another: includes under a file, overlays and ``--set`` over it.

Mappings merge member by member, ``~`` removes, everything else replaces. Four places know more:

- a component whose kind changes loses what belonged to the old kind,
- a removed component or channel takes along its connections and recorded signals, what is expected
  of it, and what turns it,
- a channel has one form of delay, so a new form replaces the old one,
- connections are added, and one into the same input replaces the earlier one.
"""

from __future__ import annotations

from cosim.base.document.node import Node, PathKey
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.scenario.source.notation import as_mapping, components_in

Path = tuple[PathKey, ...]

KINDS = ("fmu", "python", "device", "playback", "table")
"""The keys that say what computes a component; exactly one of them."""

OWNERS = {
    "flavour": "fmu",
    "substeps": "fmu",
    "feedthrough": "fmu",
    "validate": "fmu",
    "isolate": "fmu",
    "event_mode": "fmu",
    "of": "playback",
    "columns": "table",
    "interpolate": "table",
    "time_offset": "table",
}
"""Which kind of component a key belongs to, where it is one's alone."""
KIND_KEYS = (*KINDS, *OWNERS, "parameters", "start")
"""What a component loses when its kind changes; station and rate stay."""


def merge(base: Node, over: Node, path: Path = ()) -> Node:
    """``over`` on top of ``base``, both normalised; neither is changed.

    Raises:
        InputError: ``over`` removes a component, channel or connection that is not there.
    """
    if path == ("connections",) and isinstance(base.value, list) and isinstance(over.value, list):
        return Node(_connections(base.value, over.value), base.place, base.key_place)
    if not (isinstance(base.value, dict) and isinstance(over.value, dict)):
        return over
    if len(path) == 3 and path[0] == "channels" and not _is_directional(base, over):
        return over
    members = _without_replaced(base.value, over.value, path)
    gone: list[str] = []
    for key, value in over.value.items():
        old = members.get(key)
        if value.value is None:
            _check_removal(key, value, members, path)
            members.pop(key, None)
            gone.append(key)
        elif old is None:
            members[key] = _without_nulls(value, (*path, key))
        else:
            members[key] = merge(old, value, (*path, key))
    merged = Node(members, base.place, base.key_place)
    if path in {("components",), ("channels",)}:
        merged.removed = (*base.removed, *gone)
    return _without_traces_of_removed(merged) if path == () else merged


def normalise(node: Node, path: Path = ()) -> Node:
    """One spelling for what has several: connections as mappings, parameters by dotted name.

    Raises:
        InputError: a parameter is given in both spellings.
    """
    if len(path) == 2 and path[0] == "connections":
        return as_mapping(node)
    if isinstance(node.value, list) and path == ("connections",):
        return Node([as_mapping(item) for item in node.value], node.place, node.key_place)
    if not isinstance(node.value, dict):
        return node
    if is_dotted(path):
        return Node(_flat(node.value), node.place, node.key_place)
    if path and path[0] != "components":
        return node
    members = {key: normalise(value, (*path, key)) for key, value in node.value.items()}
    return Node(members, node.place, node.key_place)


def is_dotted(path: Path) -> bool:
    """Whether the mapping at ``path`` has variable names, dots included, as its keys."""
    return len(path) == 3 and path[0] == "components" and path[2] in {"parameters", "start"}


def _flat(members: dict[str, Node], prefix: str = "") -> dict[str, Node]:
    found: dict[str, Node] = {}
    for key, node in members.items():
        name = prefix + key
        inner = _flat(node.value, name + ".") if isinstance(node.value, dict) else {name: node}
        for variable, value in inner.items():
            if variable in found:
                first = found[variable].place
                raise InputError(
                    f"'{variable}' is here twice; it is first at {first}.", value.place
                )
            found[variable] = value
    return found


def _without_nulls(node: Node, path: Path) -> Node:
    """A new member: a ``~`` inside it has nothing to remove, but may not stay either."""
    return merge(Node({}, node.place, node.key_place), node, path) if node.is_mapping else node


def _without_replaced(base: dict[str, Node], over: dict[str, Node], path: Path) -> dict[str, Node]:
    """The members of ``base`` that stay when ``over`` brings another kind or form."""
    new = {key for key, node in over.items() if node.value is not None}
    dropped: set[str] = set()
    if len(path) == 2 and path[0] == "components":
        kinds = new.intersection(KINDS)
        before = set(base).intersection(KINDS)
        if kinds and before and not kinds & before:
            dropped.update(KIND_KEYS)
    if len(path) == 2 and path[0] == "channels":
        from cosim.scenario.impairments.registry import DELAY_FORMS

        form = new.intersection(DELAY_FORMS)
        if form:
            dropped.update(key for key in DELAY_FORMS if key not in form)
        dropped.update(_replaced(new))
    return {key: node for key, node in base.items() if key not in dropped}


def _replaced(new: set[str]) -> set[str]:
    """The keys of a channel that those of ``new`` stand in place of, or that stood in theirs."""
    from cosim.scenario.impairments.registry import impairments, replaced_by

    dropped: set[str] = set()
    for name in impairments():
        if name in new:
            dropped.update(replaced_by(name))
        elif new.intersection(replaced_by(name)):
            dropped.add(name)
    return dropped


def _is_directional(base: Node, over: Node) -> bool:
    """Whether both say something about a direction by name, so that they can be combined."""
    names = {"forward", "backward"}
    both = (base.value, over.value)
    return all(isinstance(value, dict) and names.issuperset(value) for value in both)


def _check_removal(key: str, node: Node, members: dict[str, Node], path: Path) -> None:
    if path in {("components",), ("channels",)} and key not in members:
        what = str(path[0]).removesuffix("s")
        hint = did_you_mean(key, members)
        raise InputError(
            f"there is no {what} '{key}' to remove.{hint}", node.key_place or node.place
        )


def _connections(base: list[Node], over: list[Node]) -> list[Node]:
    """Earlier connections with the later ones in their place or behind them."""
    merged = list(base)
    for item in over:
        removed = item.child("remove")
        if removed is not None:
            merged = _without_connection(merged, removed)
            continue
        target = item.text("to")
        slot = next((i for i, old in enumerate(merged) if old.text("to") == target), None)
        if target is None or slot is None:
            merged.append(item)
        else:
            merged[slot] = item
    return merged


def _without_connection(connections: list[Node], removed: Node) -> list[Node]:
    target = str(removed.value).rpartition("->")[2].strip()
    kept = [item for item in connections if item.text("to") != target]
    if len(kept) == len(connections):
        known = [item.text("to") or "" for item in connections]
        raise InputError(
            f"there is no connection into '{target}' to remove.{did_you_mean(target, known)}",
            removed.place,
        )
    return kept


def _without_traces_of_removed(root: Node) -> Node:
    """The document without what names a removed component or channel."""
    assert isinstance(root.value, dict)
    members = dict(root.value)
    gone = {name for key in ("components", "channels") for name in _removed(members.get(key))}
    if not gone:
        return root
    for key in ("connections", "record"):
        node = members.get(key)
        if node is not None and isinstance(node.value, list):
            kept = [item for item in node.value if not gone.intersection(_names(item))]
            members[key] = Node(kept, node.place, node.key_place)
    for key in ("expect", "knobs"):
        if (node := members.get(key)) is not None:
            members[key] = _without_signals_of(gone, node)
    events = members.get("events")
    if events is not None and isinstance(events.value, list):
        left = [_without_turning(gone, event) for event in events.value]
        kept = [event for event in left if event is not None]
        members["events"] = Node(kept, events.place, events.key_place)
    return Node(members, root.place, root.key_place)


def _without_signals_of(gone: set[str], node: Node) -> Node:
    """A mapping by signal, without the signals of what is gone."""
    if not isinstance(node.value, dict):
        return node
    kept = {key: inner for key, inner in node.value.items() if gone.isdisjoint(components_in(key))}
    return Node(kept, node.place, node.key_place)


def _without_turning(gone: set[str], event: Node) -> Node | None:
    """An event without what it turns of those that are gone; ``None`` where that was all."""
    turned = event.child("set")
    if not isinstance(event.value, dict) or turned is None or not turned.value:
        return event
    left = _without_signals_of(gone, turned)
    return Node({**event.value, "set": left}, event.place, event.key_place) if left.value else None


def _removed(node: Node | None) -> list[str]:
    """Names removed from a section and not brought back since."""
    return [name for name in node.removed if node.child(name) is None] if node is not None else []


def _names(item: Node) -> set[str]:
    """The components and the channel that a connection or a recorded pattern names."""
    signals = [item.text(key) for key in ("from", "to", "signals")] + [item.text()]
    names = {signal.partition(".")[0] for signal in signals if signal}
    return names | {item.text("via") or ""}
