"""Strings and Binaries of an FMU, mended where they are not what the standard says."""

from __future__ import annotations

from collections.abc import Sequence

from cosim.base.component import VariableType
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.loaded.conduct import Conduct
from cosim.master.fmu.loaded.residence import Residence


class TextCalls:
    """Those of one instance, while it runs."""

    def __init__(self, description: FmuDescription, residence: Residence, conduct: Conduct) -> None:
        self._references = description.references
        self._residence = residence
        self._conduct = conduct

    def get(self, kind: VariableType, names: Sequence[str], count: int) -> tuple[int, list[bytes]]:
        """The status, and the ``count`` elements of variables of one type.

        No text at all (NULL) is taken as an empty one, and what is not UTF-8 in a String is
        replaced by the sign for that; either is among what the FMU ``said``.

        Raises:
            ValueError: one is longer than what is carried.
        """
        references = [self._references[name] for name in names]
        status, found = self._residence.bound.get_texts(kind, references, count)
        self._residence.calling("")
        contents = [self._mended(content, names, kind) for content in found]
        return status, contents

    def set(self, kind: VariableType, names: Sequence[str], contents: list[bytes]) -> int:
        """The status of setting all elements of variables of one type."""
        references = [self._references[name] for name in names]
        status = self._residence.bound.set_texts(kind, references, contents)
        self._residence.calling("")
        return status

    def _mended(self, content: bytes | None, names: Sequence[str], kind: VariableType) -> bytes:
        which = names[0] if len(names) == 1 else f"one of {', '.join(names)}"
        if content is None:
            self._conduct.lapse(f"it put out no {kind} at all (NULL) as {which}")
            return b""
        if kind is VariableType.STRING:
            mended = content.decode(errors="replace").encode()
            if mended != content:
                self._conduct.lapse(f"it put out a String that is not UTF-8 as {which}")
            return mended
        return content
