"""What an FMU says that its variables mean: an annotation of our type beside each (docs/fmus.md).

FMI 3.0 has it as ``Annotation`` of type ``org.cohaptic.meaning``, FMI 2.0 as ``Tool`` of that name;
inside is a ``Meaning`` with its ``name`` for a scalar, or one with the number of its ``element``
(from 1) for each element of an array that means something. FMUs of 0.1.0 have the name as text.
Of an enumeration of FMI 3.0, in which the schema of 3.0.0 lets nothing stand, it is with the
annotations of the whole model, with the name of its ``variable``.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

from cosim.base.errors import InputError
from cosim.base.meaning import NO_SLOT, Meaning, Slot
from cosim.base.suggest import did_you_mean

TYPE = "org.cohaptic.meaning"


@dataclass(frozen=True, slots=True)
class Meant:
    """The meaning of a variable and whose it is, once or for each element."""

    meaning: Meaning | tuple[Meaning | None, ...] | None = None
    belongs_to: Slot | tuple[Slot, ...] = NO_SLOT


NOTHING = Meant()


def read_meanings(path: Path, description: Path) -> dict[str, Meant]:
    """The variables of the FMU ``path`` that mean something, by name.

    Raises:
        InputError: an annotation of our type does not say what it should.
    """
    text = description.read_bytes()
    if TYPE.encode() not in text:
        return {}
    root = ET.fromstring(text)
    variables = root.find("ModelVariables")
    found = _of_the_model(path, root)
    for variable in () if variables is None else variables:
        name = variable.get("name", "")
        for note in variable.findall("Annotations/*"):
            if TYPE in {note.get("type"), note.get("name")}:
                if name in found:
                    raise InputError(f"{path}: variable '{name}' has its meaning in two places")
                found[name] = _meant(note.findall("Meaning"), f"{path}: variable '{name}'")
    return found


def _of_the_model(path: Path, root: ET.Element) -> dict[str, Meant]:
    """What stands with the whole model: entries that name their variable, each alone."""
    names = {variable.get("name") for variable in root.findall("ModelVariables/*")}
    entries: dict[str, list[ET.Element]] = {}
    for note in root.findall("Annotations/Annotation"):
        if note.get("type") == TYPE:
            for entry in note.findall("Meaning"):
                entries.setdefault(entry.get("variable", ""), []).append(entry)
    for name in entries:
        if name not in names:
            raise InputError(
                f"{path}: an annotation {TYPE} of the model is for the variable '{name}', "
                f"which is none.{did_you_mean(name, [n for n in names if n])}"
            )
    return {name: _meant(each, f"{path}: variable '{name}'") for name, each in entries.items()}


def _meant(entries: list[ET.Element], where: str) -> Meant:
    if not entries:
        raise InputError(f"{where} has an annotation {TYPE} without a Meaning in it")
    if len(entries) == 1 and entries[0].get("element") is None:
        return Meant(*_one(entries[0], where))
    numbered = {_number(entry, "element", where) or 0: _one(entry, where) for entry in entries}
    if min(numbered) < 1 or len(numbered) != len(entries):
        raise InputError(
            f"{where} has several meanings; number each with the 'element' of the array, from 1"
        )
    each = [numbered.get(number, (None, NO_SLOT)) for number in range(1, max(numbered) + 1)]
    return Meant(tuple(meaning for meaning, _ in each), tuple(slot for _, slot in each))


def _one(entry: ET.Element, where: str) -> tuple[Meaning, Slot]:
    name, content = entry.get("name"), (entry.text or "").strip()
    if name is not None and content:
        raise InputError(
            f"{where} means '{name}' by name and '{content}' by text; write one of them"
        )
    text = content if name is None else name
    if text not in set(Meaning):
        raise InputError(f"{where} means '{text}', which is unknown.{did_you_mean(text, Meaning)}")
    return Meaning(text), Slot(_number(entry, "peer", where), _number(entry, "finger", where))


def _number(entry: ET.Element, key: str, where: str) -> int | None:
    text = entry.get(key)
    if text is None:
        return None
    if not text.isdecimal() or int(text) < 1:
        raise InputError(f"{where} has {key}='{text}' in its meaning; it is a number from 1 on")
    return int(text)
