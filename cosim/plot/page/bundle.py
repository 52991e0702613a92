"""Modules of a page in one script: what is opened from a file can load no other.

Each module becomes a function that returns what it exports. Understood is what the page's modules
use: named imports, a default import, ``export`` before a declaration, ``export { a as default }``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

_IMPORT = re.compile(r'^import (?:(\w+)|(\{[^}]*\})) from "([^"]+)";$', re.MULTILINE)
_DECLARED = re.compile(
    r"^export (?=(?:class|function|const|let|async function) (\w+))", re.MULTILINE
)
_COMMENT = re.compile(r"^/\*(?!\*).*?\*/", re.MULTILINE | re.DOTALL)
"""A block that is switched off may hold exports; one that begins with two stars is a notice."""
_LISTED = re.compile(r"^export \{([^}]*)\};?$", re.MULTILINE)


def bundle(modules: Sequence[Path]) -> str:
    """One script; a module stands behind those that it imports.

    Raises:
        ValueError: a module imports one that does not stand before it, or exports in another way.
    """
    parts = ["const modules = {};"]
    known: set[str] = set()
    for file in modules:
        parts.append(_wrapped(file.name, file.read_text(encoding="utf-8"), known))
        known.add(file.name)
    return "\n".join(parts)


def _wrapped(name: str, text: str, known: set[str]) -> str:
    exported: list[str] = []

    def imported(found: re.Match[str]) -> str:
        source = found[3].rpartition("/")[2]
        if source not in known:
            raise ValueError(f"{name} imports {source}, which does not stand before it")
        if found[1]:
            return f'const {found[1]} = modules["{source}"].default;'
        return f'const {found[2].replace(" as ", ": ")} = modules["{source}"];'

    def declared(found: re.Match[str]) -> str:
        exported.append(found[1])
        return ""

    def listed(found: re.Match[str]) -> str:
        for each in found[1].split(","):
            inner, _, outer = each.strip().partition(" as ")
            exported.append(f"{outer}: {inner}" if outer else inner)
        return ""

    text = _IMPORT.sub(imported, _COMMENT.sub("", text))
    text = _DECLARED.sub(declared, text)
    text = _LISTED.sub(listed, text)
    if left := re.search(r"^(?:import|export)\b.*", text, re.MULTILINE):
        raise ValueError(f"{name}: '{left[0]}' is no import or export that is understood")
    return f'modules["{name}"] = (() => {{\n{text}\nreturn {{ {", ".join(exported)} }};\n}})();'
