"""What every step of building a scenario needs: the document, its places, rates, problems."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from cosim.base.document.node import Node, PathKey
from cosim.base.document.problems import Problems
from cosim.base.suggest import did_you_mean
from cosim.scenario.build.timebase import Timebase
from cosim.scenario.form.document import Document
from cosim.scenario.source.find import folder_at


@dataclass(slots=True, kw_only=True)
class Context:
    """Handed from one step to the next; ``timebase`` is set once the rates are known."""

    root: Node
    problems: Problems
    document: Document
    kept: dict[str, list[int]]
    """By list section, the written index of each item of the document that is left."""
    doubtful: set[tuple[PathKey, ...]] = field(default_factory=set[tuple[PathKey, ...]])
    """Members with a problem already: nothing more follows from what they seem to say."""
    timebase: Timebase = field(default_factory=lambda: Timebase(Fraction(1)))
    refused: set[Fraction] = field(default_factory=set[Fraction])
    """Rates that do not fit; reported already."""

    def index(self, section: str, position: int) -> int:
        """Where an item of the document was in the list as written."""
        return self.kept[section][position] if section in self.kept else position

    def names(self, section: str) -> Mapping[str, Node]:
        """Every name in a section, those of members that are wrong included."""
        node = self.root.child(section)
        return node.value if node is not None and isinstance(node.value, dict) else {}

    def is_whole(self, section: str) -> bool:
        """Whether all names of a section are known: it is not wrong as a whole."""
        return (section,) not in self.doubtful

    def rate(self, written: Fraction | str | None, owner: tuple[PathKey, ...]) -> Fraction | None:
        """The rate that ``owner``'s ``rate`` means; ``None`` after reporting a problem."""
        rates = self.document.rates
        if isinstance(written, Fraction):
            return written
        if written is None:
            if len(rates) == 1:
                return next(iter(rates.values()))
            if not self.is_whole("rates"):
                return None
            where = ".".join(map(str, owner))
            hint = f" (one of {', '.join(rates)})" if rates else ""
            self.problems.add(owner, f"{where} needs a 'rate'{hint}.", at_key=True)
            return None
        if written not in rates:
            if written not in self.names("rates") and self.is_whole("rates"):
                hint = did_you_mean(written, rates)
                self.problems.add((*owner, "rate"), f"there is no rate '{written}'.{hint}")
            return None
        return rates[written]

    def rate_name(self, written: Fraction | str | None) -> str | None:
        """The name of a rate, where it was written or is the only one."""
        if written is None:
            return next(iter(self.document.rates), None)
        return written if isinstance(written, str) else None

    def folder(self, path: tuple[PathKey, ...]) -> Path:
        """The folder that a relative file name at ``path`` starts from: its own file's."""
        return folder_at(self.root.locate(path))
