"""Where a variable of a sweep goes: short names, patterns and anchors become paths of ``--set``.

``vr_*.mass`` stands for ``components.vr_a.parameters.mass`` and the same of every other component
whose name fits, ``lan.loss`` for ``channels.lan.loss``; what stands under ``x-…`` for every place
that an alias has copied it to.
"""

from __future__ import annotations

from fnmatch import fnmatchcase

from cosim.base.document.node import Node
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.scenario.form.channel import ChannelForm
from cosim.scenario.form.document import ComponentForm, Document
from cosim.scenario.form.fields import is_name
from cosim.scenario.impairments.registry import impairments
from cosim.scenario.source.override import copies_of


def expand(root: Node, text: str) -> tuple[str, ...]:
    """The paths that a place stands for.

    Raises:
        InputError: it stands for none.
    """
    first, _, rest = text.partition(".")
    if first.startswith("x-"):
        found = tuple(copies_of(root, text))
        if not found:
            raise InputError(
                f"'{text}' is used nowhere in the scenario, so that nothing would vary."
            )
        return found
    if first in Document.model_fields:
        return _in_section(root, first, rest) if first in {"components", "channels"} else (text,)
    components, channels = _names(root, "components"), _names(root, "channels")
    found = _member("components", components, first, rest)
    if first in channels or _is_of_channels(rest):
        found += _member("channels", channels, first, rest)
    if not found and not is_name(first) and not _fitting([*components, *channels], first):
        raise InputError(f"'{text}' is no place: nothing in the scenario fits '{first}'.")
    if not found:
        known = [*components, *channels, *Document.model_fields]
        raise InputError(
            f"'{text}' is no place in the scenario: write component.parameter, channel.key, or the "
            f"whole path.{did_you_mean(first, known)}"
        )
    return tuple(found)


def _in_section(root: Node, section: str, rest: str) -> tuple[str, ...]:
    name, dot, inner = rest.partition(".")
    if not dot or is_name(name):
        return (f"{section}.{rest}",)
    found = [f"{section}.{each}.{inner}" for each in _fitting(_names(root, section), name)]
    if not found:
        raise InputError(f"no {section.removesuffix('s')} fits '{name}'.")
    return tuple(found)


def _is_of_channels(rest: str) -> bool:
    """Whether a channel can have this key: a pattern is for those alone that can."""
    return rest.partition(".")[0] in ChannelForm.model_fields.keys() | impairments().keys()


def _member(section: str, names: list[str], first: str, rest: str) -> list[str]:
    if not rest:
        return []
    inner = rest
    if section == "components" and rest.partition(".")[0] not in ComponentForm.model_fields:
        inner = f"parameters.{rest}"
    return [f"{section}.{name}.{inner}" for name in _fitting(names, first)]


def _fitting(names: list[str], pattern: str) -> list[str]:
    return [name for name in names if fnmatchcase(name, pattern)]


def _names(root: Node, section: str) -> list[str]:
    node = root.child(section)
    return list(node.value) if node is not None and isinstance(node.value, dict) else []
